// The work of a step of contacts: which candidates touch, their forces, and where these go.
#include "contact/capsule_tiles.hpp"
#include "contact/compress.hpp"
#include "contact/contacts.hpp"
#include "contact/joints.hpp"
#include "contact/overlap.hpp"
#include "core/closest_points.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace skein {

namespace {

constexpr int W = CapsuleTile::width;
using P = Pack<W>;

/// Direction from one axis to the other where they intersect: across both, or across one of them where they are parallel.
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

Vec3d edge(const Exposure& c, std::size_t slot) { return c.node[slot + 1].position - c.node[slot].position; }

P lanes(const double* from) {
    P p;
    std::memcpy(&p, from, sizeof p);
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

} // namespace

/// Pairs in contact, left-packed, in order of pairs.
struct Contacts::Packed {
    static constexpr std::uint32_t most = 128, at_a_time = 64;
    alignas(64) double s[most + W], t[most + W], x[most + W], y[most + W], z[most + W], squared[most + W],
        sine_squared[most + W], radius_1[most + W], radius_2[most + W], weight[most + W];
    std::uint32_t index[most + W]; ///< of pairs
    Pair pair[most + W];
    std::uint32_t count = 0;
    std::uint32_t side_by_side[most]; ///< which of them are near-parallel
    std::uint32_t sides = 0;

    std::array<double*, 10> numbers() { return {s, t, x, y, z, squared, sine_squared, radius_1, radius_2, weight}; }
    void move(std::uint32_t from, std::uint32_t to) {
        for (double* of : numbers()) of[to] = of[from];
        index[to] = index[from];
        pair[to] = pair[from];
    }
};

struct Contacts::Sums {
    P max_overlap{0.0}, max_stiffness{0.0}, weight{0.0}, elastic_energy{0.0}, friction_work{0.0}, viscous_work{0.0};

    /// Adds the lanes whose bits are set.
    SKEIN_INLINE void add(const ContactForce<P>& f, P depth, P share, unsigned bits) {
        if (bits == 0xff) {
            weight += in_steps(share);
            max_overlap = max(max_overlap, depth), max_stiffness = max(max_stiffness, f.stiffness);
            elastic_energy += f.elastic_energy, friction_work += f.friction_work, viscous_work += f.viscous_work;
            return;
        }
        P counts(0.0);
        for (int l = 0; l < W; ++l) counts.set(l, bits >> l & 1);
        const auto counted = counts > P(0.0);
        const auto of = [&](P value) { return select(counted, value, P(0.0)); };
        weight += of(in_steps(share));
        max_overlap = max(max_overlap, of(depth)), max_stiffness = max(max_stiffness, of(f.stiffness));
        elastic_energy += of(f.elastic_energy), friction_work += of(f.friction_work), viscous_work += of(f.viscous_work);
    }
};

/// A pair in contact with all of its points: the nearest ones, and of near-parallel elements the ends of their overlap.
struct Contacts::PairContact {
    using Q = Pack<1>;
    ContactForce<Q> force; ///< at the nearest points; sums and the stiffness are those of all points
    ContactMemory<Q> memory;
    double s, t, distance, weight;             ///< the last: of all points
    ElementLoad more_on_first, more_on_second; ///< at the ends of the overlap
};

/// Appends the pairs from `begin` to `end` that touch.
void Contacts::pack(const Exposure& bodies, std::uint32_t begin, std::uint32_t end, Packed& packed, BlockFigures& figures) {
    // Pointers by themselves: what is written here might be members, for all that the compiler knows.
    const Pair* const pair = &list_.pair[begin];
    const ExposedNode* const node = bodies.node.data();
    const ExposedMotion* const motion = bodies.motion.data();
    const std::uint8_t *const previous = &previous_status_[begin], *const joints = &list_.joints[begin];
    const bool remembers = remembers_;
    const double reach_of_joints = bodies.scene().joint_reach();
    const std::uint8_t* const has_box = has_box_.empty() ? nullptr : &has_box_[begin];
    std::uint32_t n = packed.count, sides = packed.sides;
    for_capsule_tiles(
        end - begin, [&](std::size_t k) { return std::pair(node + pair[k].a, node + pair[k].b); },
        [&](std::size_t k) {
            const std::uint32_t later = pair[k + PairList::padding - W].b;
            __builtin_prefetch(node + later);
            __builtin_prefetch(node + later + 1);
        },
        [&](std::size_t k, const CapsuleTile& tile) {
            const std::uint32_t i = begin + static_cast<std::uint32_t>(k);
            const auto closest = closest_points(tile.p, tile.d1, tile.q, tile.d2, range_of_first(joints + k, reach_of_joints),
                                                range_of_second(joints + k, reach_of_joints));
            const P reach = tile.radius_1 + tile.radius_2, squared = dot(closest.apart, closest.apart);
            const unsigned listed = end - i >= W ? 0xffu : (1u << (end - i)) - 1,
                           valid = has_box ? listed & ~bits_of_bytes(has_box + k) : listed, // pairs with a box are for push_boxes
                touch = bits_of(squared < reach * reach) & valid;
            for (unsigned ended = bits_of_bytes(previous + k) & ~touch & valid; ended != 0; ended &= ended - 1)
                end_contact(bodies, i + static_cast<std::uint32_t>(std::countr_zero(ended)), figures);
            if (touch == 0) return;
            compress_store(packed.s + n, touch, closest.s);
            compress_store(packed.t + n, touch, closest.t);
            compress_store(packed.x + n, touch, closest.apart.x);
            compress_store(packed.y + n, touch, closest.apart.y);
            compress_store(packed.z + n, touch, closest.apart.z);
            compress_store(packed.squared + n, touch, squared);
            compress_store(packed.sine_squared + n, touch, closest.sine_squared);
            compress_store(packed.radius_1 + n, touch, tile.radius_1);
            compress_store(packed.radius_2 + n, touch, tile.radius_2);
            const auto both_long = min(dot(tile.d1, tile.d1), dot(tile.d2, tile.d2)) > P(0.0);
            for (unsigned side = bits_of((closest.sine_squared < P(blend * blend)) & both_long) & touch; side != 0;
                 side &= side - 1) {
                const unsigned below = touch & ((side & -side) - 1);
                packed.side_by_side[sides++] = n + static_cast<std::uint32_t>(std::popcount(below));
            }
            for (unsigned left = touch; left != 0; left &= left - 1) {
                const auto l = static_cast<std::uint32_t>(std::countr_zero(left));
                const Pair both = pair[k + l];
                packed.index[n] = i + l;
                packed.pair[n] = both;
                ++n;
                __builtin_prefetch(&motion[both.b]);
                __builtin_prefetch(&motion[both.b + 1]);
                if (!remembers) continue;
                __builtin_prefetch(&last_memory_[i + l]);
                __builtin_prefetch(&memory_[i + l], 1);
            }
        });
    packed.count = n;
    packed.sides = sides;
}

/// A contact that touched in the step before does so no longer: the energy of its spring is lost.
void Contacts::end_contact(const Exposure& bodies, std::uint32_t pair, BlockFigures& figures) const {
    if (bodies.owns_slot(list_.pair[pair].a)) figures.friction_work += last_memory_[pair].energy();
}

/// Where pairs are in contact whose elements have neighbours near there, and their share. `sides`: see joint_side; of both
/// elements.
template <int N> Contacts::Crossing<N> Contacts::crossing_at_joints(const Exposure& bodies, Pack<N> s, Pack<N> t, const Pair* pair,
                                                                    const std::int8_t (*sides)[2]) const {
    using Q = Pack<N>;
    const ExposedNode* const node = bodies.node.data();
    const double reach = bodies.scene().joint_reach();
    const auto load = [&](auto&& at) { return load_transposed<N>([&](int l) { return &at(l)->position.x; }).vector; };
    struct Element {
        Vec3<Q> start, edge, joint, beyond;
        ShareRange<Q> wide, range;
        Q radius;
    } element[2];
    for (const int body : {0, 1}) {
        Element& e = element[body];
        const auto slot = [&](int l) { return body ? pair[l].b : pair[l].a; };
        const auto at_start = load_transposed<N>([&](int l) { return &node[slot(l)].position.x; });
        e.start = at_start.vector, e.radius = at_start.behind;
        const Vec3<Q> end = load([&](int l) { return node + slot(l) + 1; });
        e.edge = end - e.start;
        const Vec3<Q> other = load([&](int l) {
            const int side = sides[l][body];
            return side == 0 ? node + slot(l) + 1 : neighbour_node(bodies, slot(l), side);
        });
        unsigned starts = 0, ends = 0;
        for (int l = 0; l < N; ++l)
            starts |= static_cast<unsigned>(sides[l][body] < 0) << l, ends |= static_cast<unsigned>(sides[l][body] > 0) << l;
        e.wide = {where_set<N>(starts, -2 * reach), Q(1.0) + where_set<N>(ends, 2 * reach)};
        e.joint = select(e.wide.high > Q(1.0), end, e.start);
        e.beyond = other - e.joint;
    }
    const Vec3<Q>&d1 = element[0].edge, &d2 = element[1].edge;
    const Q none(0.0), one(1.0), along = dot(d1, d2), sine_squared = one - along * along / max(dot(d1, d1) * dot(d2, d2), Q(1e-60)),
                                 steep = min(sine_squared * Q(1 / (shallow * shallow)), one);
    Q weight(1.0);
    for (const int body : {0, 1}) {
        Element &e = element[body], &o = element[1 - body];
        const Q at = clamp01(body ? t : s);
        const auto at_end = e.wide.high > Q(1.0), at_joint = at_end | (e.wide.low < none);
        const JointShare<Q> share = joint_share(reach, select(at_end, one - at, at), e.joint, select(at_end, -e.edge, e.edge),
                                                e.beyond, o.start, o.edge, o.wide);
        const Q shift = share.bend * (e.radius + o.radius) / max(sine_squared, Q(1e-30)), squared = min(shift * shift, one),
                straight = one - squared * squared;
        // 0 where elements are parallel, or neighbours are bent by so much that each has its own contact.
        const Q shared = select(at_joint, steep * (Q(2.0) - steep) * (straight * straight), none), beyond = shared * share.beyond;
        weight *= fma(shared, share.weight - one, one);
        e.range = {select(at_end, none, -beyond), select(at_end, one + beyond, one)};
    }
    return {
        closest_points(element[0].start, element[0].edge, element[1].start, element[1].edge, element[0].range, element[1].range),
        weight};
}

/// The same of a pair by itself, wherever it is.
Contacts::Crossing<1> Contacts::crossing(const Exposure& bodies, std::uint32_t pair) const {
    const double reach = bodies.scene().joint_reach();
    const auto [a, b] = list_.pair[pair];
    const unsigned joints = list_.joints[pair];
    const auto anywhere =
        closest_points(broadcast<1>(bodies.node[a].position), broadcast<1>(edge(bodies, a)), broadcast<1>(bodies.node[b].position),
                       broadcast<1>(edge(bodies, b)), range_with_joints<1>(joints & 1, joints >> 1 & 1, reach),
                       range_with_joints<1>(joints >> 2 & 1, joints >> 3 & 1, reach));
    const std::int8_t sides[2] = {joint_side(anywhere.s[0], joints, reach), joint_side(anywhere.t[0], joints >> 2, reach)};
    if ((sides[0] | sides[1]) == 0) return {anywhere, 1.0};
    return crossing_at_joints<1>(bodies, anywhere.s, anywhere.t, &list_.pair[pair], &sides);
}

/// Contacts near joints are put where they are, with the share that their elements have. Pairs without a share are taken out.
void Contacts::weigh(const Exposure& bodies, Packed& packed, BlockFigures& figures) {
    const double reach = bodies.scene().joint_reach();
    std::fill_n(packed.weight, packed.count, 1.0);
    std::uint32_t near[Packed::most + W], count = 0; // a joint
    std::int8_t sides[Packed::most + W][2];
    Pair pair[Packed::most + W];
    for (std::uint32_t n = 0; n < packed.count; ++n) {
        const unsigned joints = list_.joints[packed.index[n]];
        sides[count][0] = joint_side(packed.s[n], joints, reach), sides[count][1] = joint_side(packed.t[n], joints >> 2, reach);
        near[count] = n;
        pair[count] = packed.pair[n];
        count += (sides[count][0] | sides[count][1]) != 0;
    }
    if (count == 0) return;
    std::fill_n(pair + count, W, pair[0]);
    for (std::uint32_t l = 0; l < W; ++l) std::copy_n(sides[0], 2, sides[count + l]);
    for (std::uint32_t i = 0; i < count; i += W) {
        P s, t;
        for (int l = 0; l < W; ++l) {
            const std::uint32_t n = near[std::min(i + static_cast<std::uint32_t>(l), count - 1)];
            s.set(l, packed.s[n]), t.set(l, packed.t[n]);
        }
        const Crossing<W> here = crossing_at_joints<W>(bodies, s, t, pair + i, sides + i);
        const P squared = dot(here.at.apart, here.at.apart);
        for (std::uint32_t l = 0; l < W && i + l < count; ++l) {
            const int at = static_cast<int>(l);
            const std::uint32_t n = near[i + l];
            const double both = packed.radius_1[n] + packed.radius_2[n];
            packed.s[n] = here.at.s[at], packed.t[n] = here.at.t[at];
            packed.x[n] = here.at.apart.x[at], packed.y[n] = here.at.apart.y[at], packed.z[n] = here.at.apart.z[at];
            packed.squared[n] = squared[at];
            packed.weight[n] = squared[at] < both * both ? here.weight[at] : 0;
        }
    }
    std::uint32_t kept = 0, side = 0, sides_kept = 0;
    for (std::uint32_t n = 0; n < packed.count; ++n) {
        const bool near_parallel = side < packed.sides && packed.side_by_side[side] == n;
        side += near_parallel;
        if (packed.weight[n] == 0 && !near_parallel) {
            if (previous_status_[packed.index[n]] & touching) end_contact(bodies, packed.index[n], figures);
            continue;
        }
        if (near_parallel) packed.side_by_side[sides_kept++] = kept;
        packed.move(n, kept++);
    }
    packed.count = kept;
    packed.sides = sides_kept;
}

/// Where the neighbour of an element at a joint ends: its end that is not the joint. `side`: -1 before, 1 behind.
const ExposedNode* Contacts::neighbour_node(const Exposure& bodies, std::uint32_t slot, int side) {
    const std::uint32_t next = slot + static_cast<std::uint32_t>(side);
    const bool joined = next < bodies.slots() && bodies.window_of[next] == bodies.window_of[slot] && bodies.has_element(next);
    return &bodies.node[(joined ? next : bodies.beside(slot, side)) + (side > 0)];
}

/// Of a pair that did not touch: the spring of the pair at the neighbour that it shares its contact with, if that touched; else the
/// pair's own.
SKEIN_INLINE Contacts::Followed Contacts::spring_at_joint(const Exposure& bodies, std::uint32_t pair, int da, int db,
                                                          std::uint32_t own) const {
    const auto take = [&](PairList::Neighbour n, std::uint32_t else_) {
        const std::uint32_t at = n.is_candidate ? n.pair : pair;
        return n.is_candidate & ((previous_status_[at] & touching) != 0) ? at : else_;
    };
    std::uint32_t from = take(list_.beyond(pair, db == 0 ? 0 : da, db), own);
    from = take(list_.beside(pair, db), from);
    from = take(list_.beyond(pair, da, 0), from);
    return has_rings_ ? spring_at_seam(bodies, pair, da, db, {from}) : Followed{from};
}

/// The element before or behind (step -1, 1) that of a slot, where a ring closes between them.
std::optional<std::uint32_t> Contacts::beyond_seam(const Exposure& bodies, std::uint32_t slot, int step) const {
    const std::int32_t ring = scene_.gaps[static_cast<std::size_t>(bodies.at(slot).group)].ring;
    if (ring == 0 || step == 0 || bodies.element(slot) != (step < 0 ? 0 : ring - 1)) return {};
    return bodies.find(bodies.in_scene(slot) - step * (ring - 1));
}

/// The same where a ring closes at the joint: neighbours are then no neighbours by number. Elements of one ring may stand in the
/// other order beyond, where what is 1 in the law is 2 here. `otherwise`: where none closes.
Contacts::Followed Contacts::spring_at_seam(const Exposure& bodies, std::uint32_t pair, int da, int db, Followed otherwise) const {
    const auto [a, b] = list_.pair[pair];
    const auto next_a = beyond_seam(bodies, a, da), next_b = beyond_seam(bodies, b, db);
    if (!next_a && !next_b) return otherwise;
    Followed from = otherwise;
    const auto take = [&](int step_a, int step_b) {
        const std::uint32_t on_a = step_a != 0 && next_a ? *next_a : a + static_cast<std::uint32_t>(step_a),
                            on_b = step_b != 0 && next_b ? *next_b : b + static_cast<std::uint32_t>(step_b);
        const std::uint32_t at = list_.find({std::min(on_a, on_b), std::max(on_a, on_b)});
        if (at < list_.count() && (previous_status_[at] & touching) != 0) from = {at, on_a > on_b};
    };
    if (da != 0 && db != 0) take(da, db);
    if (db != 0) take(0, db);
    if (da != 0) take(da, 0);
    return from;
}

template <int N> SKEIN_INLINE Contacts::Remembered<N> Contacts::memory_before(const Exposure& bodies, const std::uint32_t* pair,
                                                                              Pack<N> s, Pack<N> t) const {
    using Q = Pack<N>;
    const auto nothing = static_cast<std::uint32_t>(list_.count());
    std::uint32_t from[N];
    for (int l = 0; l < N; ++l) from[l] = previous_status_[pair[l]] & touching ? pair[l] : nothing;
    const auto spring = load_transposed<N>([&](int l) { return &last_memory_[from[l]].spring.x.x; });
    const auto viscous_part = load_transposed<N>([&](int l) { return &last_memory_[from[l]].viscous_part.x; });
    const ContactMemory<Q> own{{spring.vector, spring.behind}, viscous_part.vector, viscous_part.behind};
    if (kinds_.friction != ContactFriction::memory) return {own, own.spring};
    unsigned turned = 0;
    bool follows = false;
    for (int l = 0; l < N; ++l) {
        if (from[l] != nothing) continue;
        const unsigned joints = list_.joints[pair[l]];
        const int da = joint_side(s[l], joints, bodies.scene().joint_reach()),
                  db = joint_side(t[l], joints >> 2, bodies.scene().joint_reach());
        if ((da | db) == 0) continue;
        const Followed followed = spring_at_joint(bodies, pair[l], da, db, nothing);
        from[l] = followed.pair;
        turned |= static_cast<unsigned>(followed.turned) << l;
        follows |= followed.pair != nothing;
    }
    if (!follows) return {own, own.spring};
    auto followed = load_transposed<N>([&](int l) { return &last_memory_[from[l]].spring.x.x; });
    for (; turned != 0; turned &= turned - 1) {
        const int l = std::countr_zero(turned);
        set_lane(followed.vector, l, -lane(followed.vector, l));
    }
    return {own, {followed.vector, followed.behind}};
}

template <int N> SKEIN_INLINE ContactNumbers<Pack<N>> Contacts::numbers(const Exposure& bodies, const std::uint32_t* pair) const {
    using Q = Pack<N>;
    auto all = numbers_[0].as<Q>();
    if (laws_.materials() == 1) return all;
    for (int l = 0; l < N; ++l) {
        const auto material = [&](std::uint32_t slot) { return static_cast<std::size_t>(bodies.at(slot).group); };
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

/// Evaluates a pair in contact by itself. Near-parallel elements push at the two ends of their overlap, and at the nearest points
/// with what is left of the normal force and all friction; turning them against each other changes the shares, and with these the
/// energy, which is a couple; so does sliding, where an overlap that ends at a joint counts by its length. `now`: the memory that
/// the contact has, where it is not to move on.                                                              theory.md (56b), (56e)
Contacts::PairContact Contacts::evaluate_pair(const Exposure& bodies, double h, std::uint32_t pair,
                                              const ContactMemory<double>* now) const {
    using Q = Pack<1>;
    const auto [a, b] = list_.pair[pair];
    const unsigned joints = list_.joints[pair];
    const ExposedNode *a0 = &bodies.node[a], *b0 = &bodies.node[b];
    const ExposedMotion *on_a = &bodies.motion[a], *on_b = &bodies.motion[b];
    const Vec3d d1 = edge(bodies, a), d2 = edge(bodies, b);
    const auto [closest, of_crossing] = crossing(bodies, pair);
    const double weight = of_crossing[0];
    const auto at_1 = [&](double s) { return a0->position + s * d1; };
    const auto at_2 = [&](double t) { return b0->position + t * d2; };
    const auto state_at = [&](double s, double t) {
        const Vec3d apart = at_2(t) - at_1(s);
        const double distance = norm(apart);
        const Vec3<Q> n = distance > 1e-150 ? broadcast<1>((1 / distance) * apart) : across<1>(broadcast<1>(d1), broadcast<1>(d2));
        return ContactState<Q>{n,
                               distance,
                               a0->radius,
                               b0->radius,
                               broadcast<1>(on_a[0].velocity + s * (on_a[1].velocity - on_a[0].velocity)),
                               broadcast<1>(on_a->spin),
                               broadcast<1>(on_b[0].velocity + t * (on_b[1].velocity - on_b[0].velocity)),
                               broadcast<1>(on_b->spin)};
    };
    const ContactNumbers<Q> law = numbers<1>(bodies, &pair);
    const double both = a0->radius + b0->radius;
    const auto energy_at = [&](double distance) { return normal_energy(kinds_.normal, law.stiffness, Q(both - distance))[0]; };
    PairContact out{.s = closest.s[0], .t = closest.t[0]};
    const double squared_1 = dot(d1, d1), squared_2 = dot(d2, d2), along = dot(d1, d2);
    double share = 0,
           beside = 1; // of the two ends in the normal force, 1 where parallel; of the overlap in a contact of whole rods
    double elsewhere = 0, elastic_energy = 0, viscous_work = 0, max_stiffness = 0;
    const ContactState<Q> state = state_at(out.s, out.t);
    out.distance = state.distance[0];
    if (closest.sine_squared[0] < blend * blend && std::min(squared_1, squared_2) > 0) {
        const double near = 1 - closest.sine_squared[0] / (blend * blend);
        share = near * near; // without a kink at the edge, where the couple would jump
        struct End {
            double s, t, distance;
        } end[2];
        for (const int k : {0, 1}) { // the end of one and its foot on the other, whichever are nearer
            const int other = along > 0 ? k : 1 - k;
            const double foot_2 = std::clamp(dot(at_1(k) - b0->position, d2) / squared_2, 0.0, 1.0),
                         foot_1 = std::clamp(dot(at_2(other) - a0->position, d1) / squared_1, 0.0, 1.0),
                         of_1 = norm(at_2(foot_2) - at_1(k)), of_2 = norm(at_2(other) - at_1(foot_1));
            if (of_1 <= of_2) end[k] = {static_cast<double>(k), foot_2, of_1};
            else end[k] = {foot_1, static_cast<double>(other), of_2};
        }
        const double energy_of_ends = 0.5 * (energy_at(end[0].distance) + energy_at(end[1].distance));
        const Overlap on_1 = overlap_on(a0->position, d1, b0->position, d2, joints & 3, joints >> 2),
                      on_2 = overlap_on(b0->position, d2, a0->position, d1, joints >> 2, joints & 3);
        beside = 0.5 * (on_1.share + on_2.share);
        const auto slide = [&](const Overlap& on, const Vec3d& start, const Vec3d& d, const Vec3d& other,
                               const Vec3d& edge_of_other, ElementLoad& on_foot, ElementLoad& on_end) {
            for (const int i : {0, 1}) {
                if (on.change[i] == 0) continue;
                const double foot = on.foot[i], per_length = 0.5 * share * energy_of_ends * on.change[i] / dot(d, d);
                const Vec3d pull = per_length * d, turn = per_length * (other + on.end[i] * edge_of_other - (start + foot * d));
                on_foot += {.first = (1 - foot) * pull + turn, .second = foot * pull - turn, .couple = {0, 0, 0}};
                (on.end[i] == 0 ? on_end.first : on_end.second) -= pull;
            }
        };
        slide(on_1, a0->position, d1, b0->position, d2, out.more_on_first, out.more_on_second);
        slide(on_2, b0->position, d2, a0->position, d1, out.more_on_second, out.more_on_first);
        for (const End& e : end) {
            ContactMemory<Q> none{};
            const Q of_end = 0.5 * share * beside;
            const auto f = contact_force<1>({kinds_.normal, ContactFriction::none}, law, state_at(e.s, e.t), h, none, none.spring,
                                            {of_end, of_end});
            elsewhere += f.normal[0], elastic_energy += f.elastic_energy[0], viscous_work += 2 * f.viscous_work[0],
                max_stiffness = std::max(max_stiffness, f.stiffness[0]);
            const Vec3d force = lane(f.on_1, 0), moment = lane(f.moment, 0);
            out.more_on_first += {.first = (1 - e.s) * force, .second = e.s * force, .couple = f.arm_1[0] * moment};
            out.more_on_second += {.first = -((1 - e.t) * force), .second = -(e.t * force), .couple = f.arm_2[0] * moment};
        }
        // How the energy changes with the share, times how the share changes as elements turn.
        const double per_share = beside * energy_of_ends - weight * energy_at(out.distance),
                     per_cosine = 4 * near * along / (blend * blend * squared_1 * squared_2);
        const Vec3d turn_1 = (per_share * per_cosine) * (d2 - (along / squared_1) * d1),
                    turn_2 = (per_share * per_cosine) * (d1 - (along / squared_2) * d2);
        out.more_on_first += {.first = turn_1, .second = -turn_1};
        out.more_on_second += {.first = turn_2, .second = -turn_2};
    }
    Remembered<1> before{};
    if (now) before = Remembered<1>::of_spring(now->spring);
    else if (remembers_) before = memory_before<1>(bodies, &pair, closest.s, closest.t);
    const double crossing = (1 - share) * weight;
    out.weight = crossing + share * beside;
    out.force = contact_force<1>(kinds_, law, state, h, before.own, before.from, {crossing, out.weight}, elsewhere);
    out.memory = before.own;
    out.force.elastic_energy += elastic_energy;
    out.force.viscous_work += viscous_work;
    out.force.stiffness = max(out.force.stiffness, Q(max_stiffness));
    return out;
}

namespace {

/// Adds the load of a contact to the slots of its element.
SKEIN_INLINE void take(ExertedLoad* at, const ElementLoad& load) {
    using Four = detail::FourDoubles;
    const auto add = [](Vec3d & to, const Vec3d& more) __attribute__((always_inline)) {
        reinterpret_cast<Four&>(to) += reinterpret_cast<const Four&>(more);
    };
    add(at[0].force, load.first);
    add(at[1].force, load.second);
    add(at[0].couple, load.couple);
}

} // namespace

void Contacts::push_packed(const Exposure& bodies, double h, const Packed& packed, const ContactBlock& block,
                           std::vector<std::size_t>& next, BlockFigures& figures, Sums& sums, std::span<ExertedLoad> loads) {
    const P one(1.0), none(0.0);
    const ExposedMotion* const motion = bodies.motion.data();
    const std::int32_t* const window = bodies.window_of.data();
    const std::uint8_t* const own = bodies.own.empty() ? nullptr : bodies.own.data();
    std::uint8_t *const status = status_.data(), *const touched = touched_.data();
    ContactMemory<double>* const kept = memory_.data();
    ExertedLoad* const load = loads.data();
    DeferredLoads::Deferring deferring = deferred_.deferring(next);
    const std::uint32_t behind = block.last_slot;
    std::uint32_t next_side = 0;
    for (std::uint32_t i = 0; i < packed.count; i += W) {
        const int count = static_cast<int>(std::min<std::uint32_t>(W, packed.count - i));
        const std::uint32_t* const index = packed.index + i;
        const Pair* const pair = packed.pair + i;
        const auto velocity_a = [&](int next) {
            return load_transposed<W>([&](int l) { return &motion[pair[l].a + static_cast<std::uint32_t>(next)].velocity.x; })
                .vector;
        };
        const auto velocity_b = [&](int next) {
            return load_transposed<W>([&](int l) { return &motion[pair[l].b + static_cast<std::uint32_t>(next)].velocity.x; })
                .vector;
        };
        const P s = lanes(packed.s + i), t = lanes(packed.t + i), radius_1 = lanes(packed.radius_1 + i),
                radius_2 = lanes(packed.radius_2 + i);
        Remembered<W> remembered{};
        if (remembers_) remembered = memory_before<W>(bodies, index, s, t);
        ContactMemory<P>& memory = remembered.own;
        const P distance = sqrt(lanes(packed.squared + i)), smaller = min(radius_1, radius_2), some = max(distance, P(1e-150));
        const P inverse = one / (some * smaller); // one division for two
        Vec3<P> normal = (smaller * inverse) * Vec3<P>{lanes(packed.x + i), lanes(packed.y + i), lanes(packed.z + i)};
        if (const auto met = distance < P(1e-150); any(met))
            for (int l = 0; l < count; ++l)
                if (met[l])
                    set_lane(normal, l,
                             lane(across<1>(broadcast<1>(edge(bodies, pair[l].a)), broadcast<1>(edge(bodies, pair[l].b))), 0));
        const ContactState<P> state{normal,
                                    distance,
                                    radius_1,
                                    radius_2,
                                    between(velocity_a(0), velocity_a(1), s),
                                    load_transposed<W>([&](int l) { return &motion[pair[l].a].spin.x; }).vector,
                                    between(velocity_b(0), velocity_b(1), t),
                                    load_transposed<W>([&](int l) { return &motion[pair[l].b].spin.x; }).vector};
        P weight = lanes(packed.weight + i);
        ContactForce<P> force =
            contact_force<W>(kinds_, numbers<W>(bodies, index), state, h, memory, remembered.from, {weight, weight});

        struct {
            int lane;
            ElementLoad on_first, on_second;
        } more[W];
        int sides = 0;
        for (; next_side < packed.sides && packed.side_by_side[next_side] < i + W; ++next_side) {
            const int l = static_cast<int>(packed.side_by_side[next_side] - i);
            const PairContact single = evaluate_pair(bodies, h, index[l]);
            weight.set(l, single.weight);
            set_lane(force.on_1, l, lane(single.force.on_1, 0));
            set_lane(force.moment, l, lane(single.force.moment, 0));
            force.elastic_energy.set(l, single.force.elastic_energy[0]);
            force.friction_work.set(l, single.force.friction_work[0]);
            force.viscous_work.set(l, single.force.viscous_work[0]);
            force.stiffness.set(l, single.force.stiffness[0]);
            set_lane(memory.spring.x, l, lane(single.memory.spring.x, 0));
            memory.spring.stiffness.set(l, single.memory.spring.stiffness[0]);
            set_lane(memory.viscous_part, l, lane(single.memory.viscous_part, 0));
            memory.weight.set(l, single.memory.weight[0]);
            more[sides++] = {l, single.more_on_first, single.more_on_second};
        }

        alignas(64) ElementLoad on_first[W], on_second[W];
        const auto share = [&](ElementLoad * to, const Vec3<P>& f, P at, const Vec3<P>& couple) __attribute__((always_inline)) {
            store_transposed<W>((one - at) * f, none, [&](int l) { return &to[l].first.x; });
            store_transposed<W>(at * f, none, [&](int l) { return &to[l].second.x; });
            store_transposed<W>(couple, none, [&](int l) { return &to[l].couple.x; });
        };
        share(on_first, force.on_1, s, force.arm_1 * force.moment);
        share(on_second, -force.on_1, t, force.arm_2 * force.moment);
        for (int m = 0; m < sides; ++m) on_first[more[m].lane] += more[m].on_first, on_second[more[m].lane] += more[m].on_second;
        if (remembers_ && count == W) {
            store_transposed<W>(memory.spring.x, memory.spring.stiffness, [&](int l) { return &kept[index[l]].spring.x.x; });
            store_transposed<W>(memory.viscous_part, memory.weight, [&](int l) { return &kept[index[l]].viscous_part.x; });
        } else if (remembers_) {
            for (int l = 0; l < count; ++l)
                kept[index[l]] = {
                    {lane(memory.spring.x, l), memory.spring.stiffness[l]}, lane(memory.viscous_part, l), memory.weight[l]};
        }
        const unsigned shared = bits_of(weight > none); // near-parallel pairs may have no share
        for (int l = 0; l < count; ++l) status[index[l]] = static_cast<std::uint8_t>((shared >> l & 1) * touching);

        unsigned mine = (1u << count) - 1; // by first bodies
        for (int l = 0; l < count; ++l) {
            const Pair both = pair[l];
            const std::int32_t first = window[both.a], second = window[both.b];
            if (!own || own[first]) {
                take(load + both.a, on_first[l]);
                touched[first] = 1;
            } else {
                mine &= ~(1u << l);
            }
            if (own && !own[second]) continue;
            if (both.b < behind) {
                take(load + both.b, on_second[l]);
                touched[second] = 1;
            } else {
                deferring.defer(second, both.b, on_second[l]);
            }
        }
        sums.add(force, P(0.5) * (radius_1 + radius_2 - distance) * (some * inverse), weight, mine);
        figures.active += std::popcount(mine & shared);
    }
}

void Contacts::push(const Exposure& bodies, double h, std::size_t number, std::vector<std::size_t>& next,
                    std::span<ExertedLoad> loads) {
    const ContactBlock& block = deferred_.blocks()[number];
    BlockFigures& figures = block_figures_[number] = {};
    std::fill(touched_.begin() + block.first_window, touched_.begin() + block.last_window, std::uint8_t{0});
    std::fill(loads.begin() + block.first_slot, loads.begin() + block.last_slot, ExertedLoad{});
    const std::uint32_t begin = list_.first[block.first_slot], end = list_.first[block.last_slot];
    if (begin == end) return;
    std::fill(status_.begin() + begin, status_.begin() + end, std::uint8_t{0});
    deferred_.open(number, next);
    Packed packed;
    Sums sums;
    for (std::uint32_t i = begin; i < end;) {
        const std::uint32_t behind = std::min(end, i + Packed::at_a_time);
        pack(bodies, i, behind, packed, figures);
        i = behind;
        if (i < end && packed.count + Packed::at_a_time <= Packed::most) continue;
        weigh(bodies, packed, figures);
        for (std::uint32_t n = packed.count; n % W != 0; ++n)
            packed.move(n / W * W, n); // the last tile is filled up with its first
        push_packed(bodies, h, packed, block, next, figures, sums, loads);
        packed.count = packed.sides = 0;
    }
    figures.max_overlap = largest(sums.max_overlap);
    figures.max_stiffness = largest(sums.max_stiffness);
    figures.weight = sum(sums.weight);
    figures.elastic_energy = sum(sums.elastic_energy);
    figures.friction_work += sum(sums.friction_work);
    figures.viscous_work = sum(sums.viscous_work);
    if (!box_pairs_.empty()) push_boxes(bodies, h, block, next, figures, loads);
    deferred_.close(number, next);
}

void Contacts::add_deferred(const Exposure& bodies, std::size_t block, std::span<ExertedLoad> loads) {
    deferred_.add_deferred(block, [&](std::uint32_t slot, const ElementLoad& load) {
        take(&loads[slot], load);
        touched_[static_cast<std::size_t>(bodies.window_of[slot])] = 1;
    });
}

std::vector<Contact> Contacts::active(const Exposure& bodies) const {
    std::vector<Contact> all;
    for (std::uint32_t i = 0; i < list_.count(); ++i) {
        const Pair pair = list_.pair[i];
        if (!(status_[i] & touching) || !bodies.owns_slot(pair.a)) continue;
        if (!has_box_.empty() && has_box_[i]) {
            all.push_back(contact_with_box(bodies, i));
            continue;
        }
        const PairContact c = evaluate_pair(bodies, 0, i, &memory_[i]); // a spring pulls as it is: what has slid has shortened it
        const Vec3d force = lane(c.force.on_1, 0) + c.more_on_first.first + c.more_on_first.second;
        const ExposedNode &a0 = bodies.node[pair.a], &b0 = bodies.node[pair.b];
        const double overlap = a0.radius + b0.radius - c.distance;
        const Vec3d at_a = a0.position + c.s * edge(bodies, pair.a), at_b = b0.position + c.t * edge(bodies, pair.b),
                    apart = at_b - at_a;
        const Vec3d normal = (1 / std::max(norm(apart), 1e-300)) * apart, arm_a = (a0.radius - 0.5 * overlap) * normal,
                    arm_b = -(b0.radius - 0.5 * overlap) * normal;
        const auto velocity = [&](std::uint32_t slot, double share, const Vec3d& arm) {
            const ExposedMotion &first = bodies.motion[slot], &second = bodies.motion[slot + 1];
            return first.velocity + share * (second.velocity - first.velocity) + cross(first.spin, arm);
        };
        all.push_back({pair, c.s, c.t, force, overlap, 2 * std::min(a0.radius, b0.radius), c.weight, at_a + arm_a, normal,
                       velocity(pair.a, c.s, arm_a) - velocity(pair.b, c.t, arm_b)});
    }
    return all;
}

// For contact_boxes.cpp.
template Contacts::Remembered<1> Contacts::memory_before<1>(const Exposure&, const std::uint32_t*, Pack<1>, Pack<1>) const;
template ContactNumbers<Pack<1>> Contacts::numbers<1>(const Exposure&, const std::uint32_t*) const;

} // namespace skein
