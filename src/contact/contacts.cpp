#include "contact/contacts.hpp"

#include "contact/capsule_tiles.hpp"
#include "core/closest_points.hpp"
#include "contact/compress.hpp"
#include "parallel/blocks.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

namespace skein {

namespace {

constexpr int W = CapsuleTile::width;
using P = Pack<W>;
constexpr double blend = 0.05; // sine of the angle below which elements meet at both ends of their overlap as well

double mean_diameter(const Capsules& c) {
    double sum = 0;
    std::size_t count = 0;
    for (const CapsuleNode& n : c.node)
        if (n.radius >= 0) sum += 2 * n.radius, ++count;
    return count > 0 ? sum / static_cast<double>(count) : 0;
}

/// From one axis to the other where they meet: across both, or across one of them where they are parallel.
template <int N> Vec3<Pack<N>> across(const Vec3<Pack<N>>& d1, const Vec3<Pack<N>>& d2) {
    using Q = Pack<N>;
    const Vec3<Q> both = cross(d1, d2),
                  one = cross(d1, select(abs(d1.x) < abs(d1.y), Vec3<Q>{Q(1.0), Q(0.0), Q(0.0)}, Vec3<Q>{Q(0.0), Q(1.0), Q(0.0)}));
    const Vec3<Q> some = select(dot(both, both) > Q(1e-24) * dot(d1, d1) * dot(d2, d2), both, one);
    return (Q(1.0) / max(norm(some), Q(1e-300))) * some;
}

template <int N> SKEIN_INLINE Vec3<Pack<N>> between(const Vec3<Pack<N>>& a, const Vec3<Pack<N>>& b, Pack<N> share) {
    return fma(share, b - a, a);
}

Vec3d edge(const Capsules& c, std::size_t slot) { return c.node[slot + 1].position - c.node[slot].position; }

P lanes(const double* from) {
    P p;
    std::memcpy(&p.v, from, sizeof p.v);
    return p;
}
double sum(P p) {
    double all = 0;
    for (int l = 0; l < W; ++l) all += p[l];
    return all;
}
double largest(P p) {
    double most = p[0];
    for (int l = 1; l < W; ++l) most = std::max(most, p[l]);
    return most;
}

/// Bit i: whether bit 0 of byte i is set.
unsigned low_bits(const std::uint8_t* bytes) {
    std::uint64_t eight;
    std::memcpy(&eight, bytes, 8);
    return static_cast<unsigned>((eight & 0x0101010101010101u) * 0x0102040810204080u >> 56);
}

} // namespace

/// Pairs that touch, one after another.
struct Contacts::Packed {
    static constexpr std::uint32_t most = 256;
    alignas(64) double s[most + W], t[most + W], x[most + W], y[most + W], z[most + W], squared[most + W], radius_1[most + W],
        radius_2[most + W];
    std::uint32_t pair[most + W];
    std::uint32_t count = 0;
    std::vector<std::uint32_t> side_by_side; ///< which of them
};

struct Contacts::Sums {
    P deepest{0.0}, stiffest{0.0}, stored{0.0}, rubbed{0.0}, damped{0.0};

    /// Of the lanes whose bits are set.
    SKEIN_INLINE void add(const ContactForce<P>& f, P depth, unsigned bits) {
        if (bits == 0xff) {
            deepest = max(deepest, depth), stiffest = max(stiffest, f.stiffness);
            stored += f.stored, rubbed += f.rubbed, damped += f.damped;
            return;
        }
        P counts(0.0);
        for (int l = 0; l < W; ++l) counts.set(l, bits >> l & 1);
        const auto counted = counts > P(0.0);
        const auto of = [&](P value) { return select(counted, value, P(0.0)); };
        deepest = max(deepest, of(depth)), stiffest = max(stiffest, of(f.stiffness));
        stored += of(f.stored), rubbed += of(f.rubbed), damped += of(f.damped);
    }
};

Contacts::Contacts(const Capsules& capsules, ContactLaws laws, const Threads& threads, std::vector<std::uint8_t> owned_rods)
    : laws_(std::move(laws)), kinds_{laws_.normal(), laws_.friction()}, threads_(threads), owned_(std::move(owned_rods)),
      search_(capsules, threads), diameter_(mean_diameter(capsules)), first_slot_(capsules.first_slot),
      touched_(capsules.first_slot.size() - 1, 0) {
    figures_.skin = 0.25 * diameter_;
}

/// Whether some of these rods have moved further than the list allows.
bool Contacts::far(const Capsules& capsules, const PairList::Task& task) const {
    const double most = 0.25 * figures_.skin * figures_.skin; // each of two may go half the way
    double furthest[4] = {};                                  // four, as a maximum waits for the one before
    const auto moved = [&](std::size_t i) {
        const Vec3d d = capsules.node[i].position - place_[i];
        return dot(d, d);
    };
    auto i = static_cast<std::size_t>(first_slot_[task.first_rod]);
    const auto end = static_cast<std::size_t>(first_slot_[task.last_rod]);
    for (; i + 4 <= end; i += 4)
        for (std::size_t k = 0; k < 4; ++k) furthest[k] = std::max(furthest[k], moved(i + k));
    for (; i < end; ++i) furthest[0] = std::max(furthest[0], moved(i));
    return !(std::max({furthest[0], furthest[1], furthest[2], furthest[3]}) < most);
}

void Contacts::carry_over(const PairList& fresh, const Capsules& capsules) {
    AlignedVector<Spring> spring(fresh.count() + 1, Spring{{0, 0, 0}, 0});
    std::vector<std::uint8_t> what(fresh.count() + PairList::padding, 0);
    const std::size_t slots = list_.count() > 0 ? fresh.first.size() - 1 : 0;
    std::vector<double> lost(blocks_of(slots), 0.0);
    for_blocks(threads_, slots, [&](std::size_t begin, std::size_t end, std::size_t block) {
        for (std::size_t a = begin; a < end; ++a) {
            std::uint32_t i = fresh.first[a];
            for (std::uint32_t old = list_.first[a]; old < list_.first[a + 1]; ++old) {
                while (i < fresh.first[a + 1] && fresh.pair[i].b < list_.pair[old].b) ++i;
                if (i < fresh.first[a + 1] && fresh.pair[i].b == list_.pair[old].b) what[i] = what_[old], spring[i] = spring_[old];
                else if (what_[old] & touching && owns(static_cast<std::size_t>(capsules.rod[a]))) lost[block] += spring_[old].energy;
            }
        }
    });
    for (const double energy : lost) figures_.rubbed += energy;
    spring_ = std::move(spring);
    what_ = std::move(what);
}

void Contacts::renew_list(const Capsules& capsules) {
    const Timers::Guard timing(figures_.search_s);
    // Few steps per list cost searches, many cost pairs that never meet.
    if (figures_.renewals > 0)
        figures_.skin = std::clamp(figures_.skin * (age_ < 20 ? 1.25 : age_ > 80 ? 0.85 : 1.0), 0.02 * diameter_, diameter_);
    age_ = 0;
    ++figures_.renewals;

    Candidates candidates;
    search_.build(capsules, figures_.skin, candidates, owned_);
    PairList fresh(std::move(candidates), capsules, threads_, kinds_.friction == ContactFriction::memory);
    carry_over(fresh, capsules);
    list_ = std::move(fresh);
    last_spring_.assign(list_.count() + 1, Spring{{0, 0, 0}, 0});
    was_.assign(list_.count() + PairList::padding, 0);
    on_second_.assign(list_.count(), PointLoad{});
    blocks_.resize(list_.tasks.size());
    task_of_rod_.resize(capsules.first_slot.size() - 1);
    for (std::uint32_t task = 0; task < list_.tasks.size(); ++task)
        for (std::uint32_t rod = list_.tasks[task].first_rod; rod < list_.tasks[task].last_rod; ++rod) task_of_rod_[rod] = task;
    place_.resize(capsules.slots());
    for (std::size_t i = 0; i < place_.size(); ++i) place_[i] = capsules.node[i].position;
}

void Contacts::restore(std::span<const KeptContact> kept, double rubbed, double damped) {
    figures_.rubbed = rubbed;
    figures_.damped = damped;
    // As if it were the list of the step before; as nobody knows how far things have moved since, it is renewed at once.
    std::vector<KeptContact> sorted(kept.begin(), kept.end());
    std::sort(sorted.begin(), sorted.end(),
              [](const KeptContact& x, const KeptContact& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
    list_ = {};
    list_.first.assign(static_cast<std::size_t>(first_slot_.back()) + 1, 0);
    what_.clear();
    spring_.clear();
    for (const KeptContact& c : sorted) {
        ++list_.first[c.a + 1];
        list_.pair.push_back({c.a, c.b});
        what_.push_back(static_cast<std::uint8_t>(c.what));
        spring_.push_back({c.spring, c.energy});
    }
    std::partial_sum(list_.first.begin(), list_.first.end(), list_.first.begin());
    place_.clear();
}

std::vector<KeptContact> Contacts::kept() const {
    std::vector<KeptContact> all;
    for (std::size_t rod = 0; rod + 1 < first_slot_.size(); ++rod) {
        if (!owns(rod)) continue;
        for (std::uint32_t i = list_.first[static_cast<std::size_t>(first_slot_[rod])];
             i < list_.first[static_cast<std::size_t>(first_slot_[rod + 1])]; ++i)
            if (what_[i] & touching) all.push_back({list_.pair[i].a, list_.pair[i].b, what_[i], spring_[i].energy, spring_[i].x});
    }
    return all;
}

/// Those of some pairs that touch.
void Contacts::pack(const Capsules& capsules, std::uint32_t begin, std::uint32_t end, Packed& packed, Block& block) {
    packed.count = 0;
    packed.side_by_side.clear();
    const Pair* const pair = &list_.pair[begin];
    const CapsuleNode* const node = capsules.node.data();
    for_capsule_tiles(
        end - begin, [&](std::size_t k) { return std::pair(node + pair[k].a, node + pair[k].b); },
        [&](std::size_t k) {
            const std::uint32_t later = pair[k + PairList::padding - W].b;
            __builtin_prefetch(node + later);
            __builtin_prefetch(node + later + 1);
            __builtin_prefetch(&capsules.spin[later]);
        },
        [&](std::size_t k, const CapsuleTile& tile) {
            const std::uint32_t i = begin + static_cast<std::uint32_t>(k);
            const auto closest = closest_points(tile.p, tile.d1, tile.q, tile.d2);
            const P reach = tile.radius_1 + tile.radius_2, squared = dot(closest.apart, closest.apart);
            const unsigned valid = end - i >= W ? 0xffu : (1u << (end - i)) - 1, touch = bits_of(squared < reach * reach) & valid;
            if (const unsigned ended = low_bits(&was_[i]) & ~touch & valid)
                for (std::uint32_t l = 0; l < W; ++l)
                    if (ended >> l & 1) {
                        on_second_[i + l] = {};
                        if (owns(static_cast<std::size_t>(capsules.rod[list_.pair[i + l].a])))
                            block.rubbed += last_spring_[i + l].energy;
                    }
            const std::uint32_t n = packed.count;
            compress_store(packed.s + n, touch, closest.s);
            compress_store(packed.t + n, touch, closest.t);
            compress_store(packed.x + n, touch, closest.apart.x);
            compress_store(packed.y + n, touch, closest.apart.y);
            compress_store(packed.z + n, touch, closest.apart.z);
            compress_store(packed.squared + n, touch, squared);
            compress_store(packed.radius_1 + n, touch, tile.radius_1);
            compress_store(packed.radius_2 + n, touch, tile.radius_2);
            for (std::uint32_t l = 0; l < W; ++l) {
                packed.pair[packed.count] = i + l;
                packed.count += touch >> l & 1;
            }
            if (const unsigned side = bits_of((closest.sine_squared < P(blend * blend)) & (closest.last > closest.first)) & touch)
                for (std::uint32_t l = 0; l < W; ++l)
                    if (side >> l & 1)
                        packed.side_by_side.push_back(n + static_cast<std::uint32_t>(std::popcount(touch & ((1u << l) - 1))));
        });
    // The last tile is filled up with its first.
    for (std::uint32_t i = packed.count, first = packed.count / W * W; i % W != 0; ++i) {
        for (double* of : {packed.s, packed.t, packed.x, packed.y, packed.z, packed.squared, packed.radius_1, packed.radius_2})
            of[i] = of[first];
        packed.pair[i] = packed.pair[first];
    }
}

/// At a joint: the spring of the neighbour beyond, if that touched within its elements; else the pair's own.
SKEIN_INLINE std::uint32_t Contacts::spring_at_joint(std::uint32_t pair, int da, int db, std::uint32_t own) const {
    const auto take = [&](PairList::Neighbour n, std::uint32_t else_) {
        const std::uint32_t at = n.listed ? n.pair : pair;
        return n.listed & ((was_[at] & inside) != 0) ? at : else_;
    };
    std::uint32_t from = take(list_.beyond(pair, db == 0 ? 0 : da, db), own);
    from = take(list_.beside(pair, db), from);
    return take(list_.beyond(pair, da, 0), from);
}

/// x of contacts before this step, and what energy theirs had.
template <int N>
SKEIN_INLINE ContactSpring<Pack<N>> Contacts::springs_before(const std::uint32_t* pair, Pack<N> s, Pack<N> t) const {
    using Q = Pack<N>;
    const auto nothing = static_cast<std::uint32_t>(list_.count());
    std::uint32_t from[N];
    for (int l = 0; l < N; ++l) from[l] = was_[pair[l]] & touching ? pair[l] : nothing;
    const auto load = [&] { return load_transposed<N>([&](int l) { return &last_spring_[from[l]].x.x; }); };
    const auto own = load();
    const unsigned a_low = bits_of(s <= Q(0.0)), a_high = bits_of(s >= Q(1.0)), b_low = bits_of(t <= Q(0.0)),
                   b_high = bits_of(t >= Q(1.0));
    unsigned at_joint = a_low | a_high | b_low | b_high;
    if (at_joint == 0) return {own.vector, own.behind};
    for (; at_joint != 0; at_joint &= at_joint - 1) {
        const int l = std::countr_zero(at_joint);
        const auto step = [l](unsigned low, unsigned high) {
            return static_cast<int>(high >> l & 1) - static_cast<int>(low >> l & 1);
        };
        from[l] = spring_at_joint(pair[l], step(a_low, a_high), step(b_low, b_high), from[l]);
    }
    return {load().vector, own.behind};
}

template <int N> SKEIN_INLINE ContactNumbers<Pack<N>> Contacts::numbers(const Capsules& capsules, const std::uint32_t* pair) const {
    using Q = Pack<N>;
    auto all = numbers_[0].as<Q>();
    if (laws_.materials() == 1) return all;
    for (int l = 0; l < N; ++l) {
        const auto material = [&](std::uint32_t slot) {
            return static_cast<std::size_t>(capsules.material[static_cast<std::size_t>(capsules.rod[slot])]);
        };
        const ContactNumbers<double>& law =
            numbers_[material(list_.pair[pair[l]].a) * laws_.materials() + material(list_.pair[pair[l]].b)];
        all.stiffness.set(l, law.stiffness);
        all.damping.set(l, law.damping);
        all.static_friction.set(l, law.static_friction);
        all.kinetic_friction.set(l, law.kinetic_friction);
        all.tangential_stiffness.set(l, law.tangential_stiffness);
        all.tangential_damping.set(l, law.tangential_damping);
        all.slip_speed.set(l, law.slip_speed);
    }
    return all;
}

/// Forces at the two ends of the overlap, and that at the nearest point again, with what is left of the normal force and all
/// friction.
Contacts::Ends Contacts::side_by_side(const Capsules& capsules, double h, std::uint32_t pair, int l, ContactForce<P>& force,
                                      ContactSpring<P>& spring) const {
    using Q = Pack<1>;
    const auto [a, b] = list_.pair[pair];
    const CapsuleNode *a0 = &capsules.node[a], *a1 = a0 + 1, *b0 = &capsules.node[b], *b1 = b0 + 1;
    const Vec3d d1 = edge(capsules, a), d2 = edge(capsules, b);
    const auto closest = closest_points(broadcast<1>(a0->position), broadcast<1>(d1), broadcast<1>(b0->position), broadcast<1>(d2));
    const double share = 1 - closest.sine_squared[0] / (blend * blend); // of the normal force that the two ends take
    const auto at = [&](double s, double t) {
        const Vec3d apart = b0->position + t * d2 - (a0->position + s * d1);
        const double distance = norm(apart);
        const Vec3<Q> n = distance > 1e-150 ? broadcast<1>((1 / distance) * apart) : across<1>(broadcast<1>(d1), broadcast<1>(d2));
        return ContactState<Q>{n,
                               distance,
                               a0->radius,
                               b0->radius,
                               broadcast<1>(a0->velocity + s * (a1->velocity - a0->velocity)),
                               broadcast<1>(capsules.spin[a].spin),
                               broadcast<1>(b0->velocity + t * (b1->velocity - b0->velocity)),
                               broadcast<1>(capsules.spin[b].spin)};
    };
    const ContactNumbers<Q> law = numbers<1>(capsules, &pair);
    Ends ends{.pair = pair, .first = {}, .second = {}};
    double elsewhere = 0, stored = 0, damped = 0, stiffest = 0;
    for (int i = 0; i < 2; ++i) {
        const double s = i == 0 ? closest.first[0] : closest.last[0],
                     t = std::clamp(dot(a0->position + s * d1 - b0->position, d2) / dot(d2, d2), 0.0, 1.0);
        ContactSpring<Q> none{broadcast<1>(Vec3d{0, 0, 0}), 0.0};
        const auto f = contact_force<1>({kinds_.normal, ContactFriction::none}, law, at(s, t), h, none, 0.5 * share);
        elsewhere += f.normal[0], stored += f.stored[0], damped += f.damped[0], stiffest = std::max(stiffest, f.stiffness[0]);
        const Vec3d on_1 = lane(f.on_1, 0), moment = lane(f.moment, 0);
        ends.first[i] = {on_1, s, f.arm_1[0] * moment, t};
        ends.second[i] = {-on_1, t, f.arm_2[0] * moment, s};
    }
    ContactSpring<Q> one{broadcast<1>(Vec3d{0, 0, 0}), 0.0};
    if (kinds_.friction == ContactFriction::memory) one = springs_before<1>(&pair, closest.s, closest.t);
    const auto f = contact_force<1>(kinds_, law, at(closest.s[0], closest.t[0]), h, one, 1 - share, elsewhere);
    set_lane(force.on_1, l, lane(f.on_1, 0));
    set_lane(force.moment, l, lane(f.moment, 0));
    force.stored.set(l, f.stored[0] + stored);
    force.rubbed.set(l, f.rubbed[0]);
    force.damped.set(l, f.damped[0] + damped);
    force.stiffness.set(l, std::max(f.stiffness[0], stiffest));
    set_lane(spring.x, l, lane(one.x, 0));
    spring.energy.set(l, one.energy[0]);
    return ends;
}

namespace {

/// What a point does to the slots of its element.
template <class Point> SKEIN_INLINE void take(ContactLoad* at, const Point& p) {
    using Four = detail::FourDoubles;
    const Four force = *reinterpret_cast<const Four*>(&p.force), couple = *reinterpret_cast<const Four*>(&p.couple);
    *reinterpret_cast<Four*>(&at[0].force) += (1 - p.share) * force;
    *reinterpret_cast<Four*>(&at[1].force) += p.share * force;
    *reinterpret_cast<Four*>(&at[0].couple) += couple;
}

} // namespace

void Contacts::push_packed(const Capsules& capsules, double h, const Packed& packed, Block& block, Sums& sums,
                           AlignedVector<ContactLoad>& loads) {
    std::size_t next_side = 0;
    for (std::uint32_t i = 0; i < packed.count; i += W) {
        const int count = static_cast<int>(std::min<std::uint32_t>(W, packed.count - i));
        const std::uint32_t* index = packed.pair + i;
        Pair pair[W];
        for (int l = 0; l < W; ++l) pair[l] = list_.pair[index[l]];
        const auto velocity_a = [&](int next) {
            return load_transposed<W>([&](int l) { return &(&capsules.node[pair[l].a])[next].velocity.x; }).vector;
        };
        const auto velocity_b = [&](int next) {
            return load_transposed<W>([&](int l) { return &(&capsules.node[pair[l].b])[next].velocity.x; }).vector;
        };
        const P s = lanes(packed.s + i), t = lanes(packed.t + i), radius_1 = lanes(packed.radius_1 + i),
                radius_2 = lanes(packed.radius_2 + i);
        ContactSpring<P> spring{broadcast<W>(Vec3d{0, 0, 0}), 0.0};
        if (kinds_.friction == ContactFriction::memory) spring = springs_before<W>(index, s, t);
        const P distance = sqrt(lanes(packed.squared + i)), smaller = min(radius_1, radius_2), some = max(distance, P(1e-150));
        const P inverse = P(1.0) / (some * smaller); // one division for two
        Vec3<P> normal = (smaller * inverse) * Vec3<P>{lanes(packed.x + i), lanes(packed.y + i), lanes(packed.z + i)};
        if (const auto met = distance < P(1e-150); any(met))
            for (int l = 0; l < count; ++l)
                if (met[l])
                    set_lane(normal, l,
                             lane(across<1>(broadcast<1>(edge(capsules, pair[l].a)), broadcast<1>(edge(capsules, pair[l].b))), 0));
        const ContactState<P> state{normal,
                                    distance,
                                    radius_1,
                                    radius_2,
                                    between(velocity_a(0), velocity_a(1), s),
                                    load_transposed<W>([&](int l) { return &capsules.spin[pair[l].a].spin.x; }).vector,
                                    between(velocity_b(0), velocity_b(1), t),
                                    load_transposed<W>([&](int l) { return &capsules.spin[pair[l].b].spin.x; }).vector};
        ContactForce<P> force = contact_force<W>(kinds_, numbers<W>(capsules, index), state, h, spring);

        unsigned sides = 0;
        const std::size_t first_ends = block.ends.size();
        for (; next_side < packed.side_by_side.size() && packed.side_by_side[next_side] < i + W; ++next_side) {
            const int l = static_cast<int>(packed.side_by_side[next_side] - i);
            block.ends.push_back(side_by_side(capsules, h, index[l], l, force, spring));
            sides |= 1u << l;
        }
        if (sides != 0)
            for (int l = count; l < W; ++l) { // lanes without a pair repeat the first
                set_lane(force.on_1, l, lane(force.on_1, 0));
                set_lane(force.moment, l, lane(force.moment, 0));
                set_lane(spring.x, l, lane(spring.x, 0));
                spring.energy.set(l, spring.energy[0]);
            }

        alignas(64) PointLoad on_first[W];
        store_transposed<W>(force.on_1, s, [&](int l) { return &on_first[l].force.x; });
        store_transposed<W>(force.arm_1 * force.moment, t, [&](int l) { return &on_first[l].couple.x; });
        store_transposed<W>(-force.on_1, t, [&](int l) { return &on_second_[index[l]].force.x; });
        store_transposed<W>(force.arm_2 * force.moment, s, [&](int l) { return &on_second_[index[l]].couple.x; });
        if (kinds_.friction == ContactFriction::memory)
            store_transposed<W>(spring.x, spring.energy, [&](int l) { return &spring_[index[l]].x.x; });
        const unsigned within = bits_of((s > P(0.0)) & (s < P(1.0)) & (t > P(0.0)) & (t < P(1.0)));
        for (int l = 0; l < W; ++l) what_[index[l]] = static_cast<std::uint8_t>(touching | (within >> l & 1) * inside);
        if (sides != 0)
            for (int l = 0; l < count; ++l) what_[index[l]] |= static_cast<std::uint8_t>((sides >> l & 1) * has_ends);

        unsigned mine = (1u << count) - 1;
        if (!owned_.empty())
            for (int l = 0; l < count; ++l)
                if (!owns(static_cast<std::size_t>(capsules.rod[pair[l].a]))) mine &= ~(1u << l);
        if (mine == 0xff && sides == 0) {
            for (int l = 0; l < W; ++l) take(&loads[pair[l].a], on_first[l]);
        } else {
            const Ends* ends = block.ends.data() + first_ends;
            for (int l = 0; l < count; ++l) {
                const bool side = sides >> l & 1;
                if (mine >> l & 1) {
                    take(&loads[pair[l].a], on_first[l]);
                    for (int e = 0; side && e < 2; ++e) take(&loads[pair[l].a], ends->first[e]);
                }
                ends += side;
            }
        }
        sums.add(force, P(0.5) * (radius_1 + radius_2 - distance) * (some * inverse), mine);
        block.active += std::popcount(mine);
    }
}

void Contacts::push(const Capsules& capsules, double h, const PairList::Task& task, Block& block,
                    AlignedVector<ContactLoad>& loads) {
    block.ends.clear();
    block.listed = block.active = 0;
    block.deepest = block.stiffest = block.stored = block.rubbed = block.damped = 0;
    const auto slot = [&](std::uint32_t rod) { return static_cast<std::size_t>(first_slot_[rod]); };
    for (std::uint32_t rod = task.first_rod; rod < task.last_rod; ++rod) {
        if (!owns(rod)) continue;
        const std::uint32_t listed = list_.first[slot(rod + 1)] - list_.first[slot(rod)];
        block.listed += listed;
        if (listed == 0 && list_.reverse_begin[slot(rod + 1)] == list_.reverse_begin[slot(rod)]) continue;
        std::memset(static_cast<void*>(&loads[slot(rod)]), 0, (slot(rod + 1) - slot(rod)) * sizeof(ContactLoad));
    }
    if (task.first_pair == task.last_pair) return;
    std::fill(what_.begin() + task.first_pair, what_.begin() + task.last_pair, std::uint8_t{0});
    Packed packed;
    Sums sums;
    for (std::uint32_t i = task.first_pair; i < task.last_pair; i += Packed::most) {
        pack(capsules, i, std::min(task.last_pair, i + Packed::most), packed, block);
        push_packed(capsules, h, packed, block, sums, loads);
    }
    block.deepest = largest(sums.deepest);
    block.stiffest = largest(sums.stiffest);
    block.stored = sum(sums.stored);
    block.rubbed += sum(sums.rubbed);
    block.damped = sum(sums.damped);
}

const Contacts::Ends* Contacts::ends_of(std::size_t pair, std::size_t a, const Capsules& capsules) const {
    const auto& ends = blocks_[task_of_rod_[static_cast<std::size_t>(capsules.rod[a])]].ends;
    return &*std::lower_bound(ends.begin(), ends.end(), pair, [](const Ends& e, std::size_t p) { return e.pair < p; });
}

void Contacts::gather_rod(const Capsules& capsules, std::size_t rod, AlignedVector<ContactLoad>& loads) {
    const auto first = static_cast<std::size_t>(first_slot_[rod]), behind = static_cast<std::size_t>(first_slot_[rod + 1]);
    std::uint8_t touched = 0;
    for (std::uint32_t i = list_.first[first]; i < list_.first[behind]; ++i) touched |= what_[i];
    // All pairs, as those that do not touch add zeros and cost less than to ask which.
    const std::uint32_t begin = list_.reverse_begin[first], end = list_.reverse_begin[behind];
    for (std::uint32_t i = begin; i < end; ++i) {
        __builtin_prefetch(&on_second_[list_.reverse[std::min(i + 16, end - 1)]]);
        const std::uint32_t pair = list_.reverse[i];
        const std::uint8_t what = what_[pair];
        touched |= what;
        ContactLoad* at = &loads[list_.pair[pair].b];
        take(at, on_second_[pair]);
        if (what & has_ends)
            for (const PointLoad& point : ends_of(pair, list_.pair[pair].a, capsules)->second) take(at, point);
    }
    touched_[rod] = touched != 0;
}

void Contacts::gather(const Capsules& capsules, const PairList::Task& task, AlignedVector<ContactLoad>& loads) {
    for (std::uint32_t rod = task.first_rod; rod < task.last_rod; ++rod)
        if (owns(rod)) gather_rod(capsules, rod, loads);
}

/// Loads of all contacts, unless some rod turns out to have moved too far for the list.
bool Contacts::push_all(const Capsules& capsules, double h, AlignedVector<ContactLoad>& loads) {
    const auto& tasks = list_.tasks;
    const std::size_t strips =
        threads_.count() == 1 ? 1 : std::min<std::size_t>(tasks.size(), 2 * static_cast<std::size_t>(threads_.count()));
    const auto begin_of = [&](std::size_t strip) { return strip * tasks.size() / strips; };
    std::atomic<bool> too_far = false;
    std::vector<std::uint8_t> gathered(tasks.size(), 0);
    threads_.for_each(strips, [&](std::size_t strip, int) {
        for (std::size_t t = begin_of(strip); t < begin_of(strip + 1); ++t) {
            if (too_far.load(std::memory_order_relaxed)) return;
            if (far(capsules, tasks[t])) too_far.store(true, std::memory_order_relaxed);
            push(capsules, h, tasks[t], blocks_[t], loads);
            if (tasks[t].first_needed < tasks[begin_of(strip)].first_pair) continue;
            gather(capsules, tasks[t], loads);
            gathered[t] = 1;
        }
    });
    if (too_far) return false;
    if (strips > 1)
        threads_.for_each(tasks.size(), [&](std::size_t t, int) {
            if (!gathered[t]) gather(capsules, tasks[t], loads);
        });
    return true;
}

void Contacts::evaluate(const Capsules& capsules, double time, double h, AlignedVector<ContactLoad>& loads) {
    numbers_ = laws_.numbers(time);
    loads.resize(capsules.slots());
    if (place_.size() != capsules.slots()) renew_list(capsules);
    const auto turn = [&] { // what was new is what was before
        std::swap(spring_, last_spring_);
        std::swap(what_, was_);
    };
    turn();
    if (!push_all(capsules, h, loads)) {
        turn(); // as if this step had not begun
        renew_list(capsules);
        turn();
        push_all(capsules, h, loads);
    }
    ++age_;
    ContactFigures& f = figures_;
    f.listed = f.active = 0;
    f.deepest = f.stiffest = f.stored = 0;
    for (const Block& block : blocks_) {
        f.listed += block.listed, f.active += block.active;
        f.deepest = std::max(f.deepest, block.deepest), f.stiffest = std::max(f.stiffest, block.stiffest);
        f.stored += block.stored, f.rubbed += block.rubbed, f.damped += block.damped;
    }
}

std::vector<Contact> Contacts::active(const Capsules& capsules) const {
    std::vector<Contact> all;
    for (std::size_t i = 0; i < list_.count(); ++i) {
        const Pair pair = list_.pair[i];
        if (!(what_[i] & touching) || !owns(static_cast<std::size_t>(capsules.rod[pair.a]))) continue;
        const PointLoad& on = on_second_[i];
        const double s = on.share_of_other, t = on.share;
        const CapsuleNode &a = capsules.node[pair.a], &b = capsules.node[pair.b];
        const Vec3d apart = b.position + t * edge(capsules, pair.b) - (a.position + s * edge(capsules, pair.a));
        Vec3d force = -on.force;
        if (what_[i] & has_ends)
            for (const PointLoad& end : ends_of(i, pair.a, capsules)->first) force += end.force;
        all.push_back({pair, s, t, force, a.radius + b.radius - norm(apart)});
    }
    return all;
}

} // namespace skein
