#include "contact/contacts.hpp"

#include "contact/closest_points.hpp"
#include "parallel/blocks.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace skein {

namespace {

constexpr double blend = 0.05;           // sine of the angle below which elements meet at both ends of their overlap as well

double mean_diameter(const Capsules& c) {
    double sum = 0;
    std::size_t count = 0;
    for (const CapsuleNode& n : c.node)
        if (n.radius >= 0) sum += 2 * n.radius, ++count;
    return count > 0 ? sum / static_cast<double>(count) : 0;
}

/// From one axis to the other; where they meet, across both, or across one of them where they are parallel.
template <int W> Vec3<Pack<W>> direction(const Vec3<Pack<W>>& apart, Pack<W> distance, const Vec3<Pack<W>>& d1, const Vec3<Pack<W>>& d2) {
    using P = Pack<W>;
    const auto some = distance > P(1e-150);
    if (!any(!some)) return (P(1.0) / distance) * apart;
    const Vec3<P> both = cross(d1, d2), one = cross(d1, select(abs(d1.x) < abs(d1.y), Vec3<P>{P(1.0), P(0.0), P(0.0)}, Vec3<P>{P(0.0), P(1.0), P(0.0)}));
    const Vec3<P> across = select(dot(both, both) > P(1e-24) * dot(d1, d1) * dot(d2, d2), both, one);
    return select(some, (P(1.0) / max(distance, P(1e-150))) * apart, (P(1.0) / max(norm(across), P(1e-300))) * across);
}

template <int W> Vec3<Pack<W>> between(const Vec3<Pack<W>>& a, const Vec3<Pack<W>>& b, Pack<W> share) { return fma(share, b - a, a); }

} // namespace

Contacts::Contacts(const Capsules& capsules, const ContactLaw& law, const Threads& threads) : law_(law), threads_(threads), search_(capsules, threads), diameter_(mean_diameter(capsules)) {
    figures_.skin = 0.25 * diameter_;
}

bool Contacts::list_is_used_up(const Capsules& capsules) const {
    if (place_.size() != capsules.slots()) return true;
    std::atomic<bool> far = false;
    const double most = 0.25 * figures_.skin * figures_.skin; // each of two may go half the way
    for_blocks(threads_, place_.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        double furthest = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3d moved = capsules.node[i].position - place_[i];
            furthest = std::max(furthest, dot(moved, moved));
        }
        if (!(furthest < most)) far.store(true, std::memory_order_relaxed);
    });
    return far;
}

std::optional<std::size_t> Contacts::find(std::uint32_t a, std::uint32_t b) const {
    const auto partners = candidates_.of(a);
    const auto at = std::lower_bound(partners.begin(), partners.end(), b);
    if (at == partners.end() || *at != b) return std::nullopt;
    return static_cast<std::size_t>(at - partners.begin()) + candidates_.first[a];
}

void Contacts::renew_list(const Capsules& capsules) {
    // Few steps per list cost searches, many cost pairs that never meet.
    if (figures_.renewals > 0) figures_.skin = std::clamp(figures_.skin * (age_ < 20 ? 1.25 : age_ > 80 ? 0.85 : 1.0), 0.02 * diameter_, diameter_);
    age_ = 0;
    ++figures_.renewals;

    Candidates fresh;
    search_.build(capsules, figures_.skin, fresh);
    std::vector<Pair> pairs(fresh.count());
    std::vector<Vec3d> spring(fresh.count(), Vec3d{0, 0, 0});
    std::vector<std::uint8_t> active(fresh.count(), 0);
    std::vector<std::uint32_t> seconds(capsules.slots() + 1, 0);
    for_blocks(threads_, capsules.slots(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t a = begin; a < end; ++a)
            for (std::size_t i = fresh.first[a]; i < fresh.first[a + 1]; ++i) {
                pairs[i] = {static_cast<std::uint32_t>(a), fresh.partner[i]};
                std::atomic_ref(seconds[pairs[i].b]).fetch_add(1, std::memory_order_relaxed);
                if (pairs_.empty()) continue;
                if (const auto old = find(pairs[i].a, pairs[i].b)) spring[i] = spring_[*old], active[i] = active_[*old];
            }
    });
    candidates_ = std::move(fresh);
    pairs_ = std::move(pairs);
    spring_ = std::move(spring);
    active_ = std::move(active);
    last_spring_.resize(pairs_.size());
    was_active_.resize(pairs_.size());
    force_.resize(pairs_.size());
    overlap_.resize(pairs_.size());

    reverse_begin_ = std::move(seconds);
    begins_from_counts(threads_, reverse_begin_);
    reverse_.resize(pairs_.size());
    std::vector<std::uint32_t> filled(reverse_begin_);
    for_blocks(threads_, pairs_.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t i = begin; i < end; ++i)
            reverse_[std::atomic_ref(filled[pairs_[i].b]).fetch_add(1, std::memory_order_relaxed)] = static_cast<std::uint32_t>(i);
    });
    for_blocks(threads_, capsules.slots(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t b = begin; b < end; ++b) std::sort(reverse_.begin() + reverse_begin_[b], reverse_.begin() + reverse_begin_[b + 1]);
    });

    place_.resize(capsules.slots());
    for (std::size_t i = 0; i < place_.size(); ++i) place_[i] = capsules.node[i].position;
}

Vec3d Contacts::spring_before(const Capsules& capsules, std::size_t index, double s, double t) const {
    const Pair& pair = pairs_[index];
    const int da = s <= 0 ? -1 : s >= 1 ? 1 : 0, db = t <= 0 ? -1 : t >= 1 ? 1 : 0;
    const auto on_rod = [&](std::uint32_t slot, int step) {
        const std::int64_t other = std::int64_t{slot} + step;
        return other >= 0 && other < static_cast<std::int64_t>(capsules.slots()) && capsules.rod[static_cast<std::size_t>(other)] == capsules.rod[slot];
    };
    for (const auto& [step_a, step_b] : {std::pair{da, 0}, std::pair{0, db}, std::pair{da, db}}) {
        if ((step_a == 0 && step_b == 0) || !on_rod(pair.a, step_a) || !on_rod(pair.b, step_b)) continue;
        const auto a = static_cast<std::uint32_t>(static_cast<int>(pair.a) + step_a), b = static_cast<std::uint32_t>(static_cast<int>(pair.b) + step_b);
        if (const auto i = find(a, b); i && (was_active_[*i] & inside)) return last_spring_[*i];
        if (const auto i = find(b, a); i && (was_active_[*i] & inside)) return -last_spring_[*i];
    }
    return was_active_[index] ? last_spring_[index] : Vec3d{0, 0, 0};
}

void Contacts::meet(const Capsules& capsules, double h, std::size_t begin, std::size_t end, Block& block) {
    constexpr int W = 8;
    using P = Pack<W>;
    block = {};
    for (std::size_t i = begin; i < end; i += W) {
        const double *x[4][W], *v[4][W], *w[2][W];
        for (int l = 0; l < W; ++l) {
            const Pair& pair = pairs_[std::min(i + static_cast<std::size_t>(l), end - 1)];
            const CapsuleNode *a = &capsules.node[pair.a], *b = &capsules.node[pair.b];
            const CapsuleNode* nodes[4] = {a, a + 1, b, b + 1};
            for (int n = 0; n < 4; ++n) x[n][l] = &nodes[n]->position.x, v[n][l] = &nodes[n]->velocity.x;
            w[0][l] = &capsules.spin[pair.a].spin.x, w[1][l] = &capsules.spin[pair.b].spin.x;
        }
        const auto a = load_transposed<W>(x[0]), a_end = load_transposed<W>(x[1]), b = load_transposed<W>(x[2]), b_end = load_transposed<W>(x[3]);
        const Vec3<P> d1 = a_end.vector - a.vector, d2 = b_end.vector - b.vector;
        const auto closest = closest_points(a.vector, d1, b.vector, d2);
        const P reach = a.behind + b.behind, squared = dot(closest.apart, closest.apart);
        const auto touches = squared < reach * reach;
        const int count = static_cast<int>(std::min<std::size_t>(W, end - i));
        if (!any(touches)) {
            std::fill_n(active_.begin() + static_cast<std::ptrdiff_t>(i), count, std::uint8_t{0});
            continue;
        }
        Vec3<P> spring{P(0.0), P(0.0), P(0.0)};
        if (law_.friction == ContactFriction::memory)
            for (int l = 0; l < count; ++l) {
                const std::size_t pair = i + static_cast<std::size_t>(l);
                if (touches[l]) set_lane(spring, l, spring_before(capsules, pair, closest.s[l], closest.t[l]));
            }
        const P distance = sqrt(squared);
        const ContactState<P> state{direction(closest.apart, distance, d1, d2),
                                    distance,
                                    a.behind,
                                    b.behind,
                                    between(load_transposed<W>(v[0]).vector, load_transposed<W>(v[1]).vector, closest.s),
                                    load_transposed<W>(w[0]).vector,
                                    between(load_transposed<W>(v[2]).vector, load_transposed<W>(v[3]).vector, closest.t),
                                    load_transposed<W>(w[1]).vector};
        const ContactForce<P> force = contact_force(law_, state, h, spring);
        for (int l = 0; l < count; ++l) {
            const std::size_t pair = i + static_cast<std::size_t>(l);
            active_[pair] = 0;
            if (!touches[l]) continue;
            const bool within = closest.s[l] > 0 && closest.s[l] < 1 && closest.t[l] > 0 && closest.t[l] < 1;
            active_[pair] = within ? touching | inside : touching;
            force_[pair] = {lane(force.on_1, l), lane(force.moment, l), closest.s[l], closest.t[l], force.arm_1[l], force.arm_2[l]};
            spring_[pair] = lane(spring, l);
            overlap_[pair] = reach[l] - distance[l];
            ++block.active;
            block.deepest = std::max(block.deepest, overlap_[pair] / (2 * std::min(a.behind[l], b.behind[l])));
            if (closest.sine_squared[l] < blend * blend && closest.last[l] > closest.first[l])
                meet_side_by_side(capsules, h, static_cast<std::uint32_t>(pair), closest.sine_squared[l], closest.first[l], closest.last[l], block);
        }
    }
}

void Contacts::meet_side_by_side(const Capsules& capsules, double h, std::uint32_t pair, double sine_squared, double first, double last, Block& block) {
    const auto [a, b] = pairs_[pair];
    const CapsuleNode *a0 = &capsules.node[a], *a1 = a0 + 1, *b0 = &capsules.node[b], *b1 = b0 + 1;
    const Vec3d d1 = a1->position - a0->position, d2 = b1->position - b0->position;
    const double share = 1 - sine_squared / (blend * blend); // of the normal force that the two ends take
    const auto at = [&](double s, double t) {
        const Vec3d apart = b0->position + t * d2 - (a0->position + s * d1);
        const double distance = norm(apart);
        const Vec3d n = lane(direction(broadcast<1>(apart), Pack<1>(distance), broadcast<1>(d1), broadcast<1>(d2)), 0);
        return ContactState<Pack<1>>{broadcast<1>(n),
                                     distance,
                                     a0->radius,
                                     b0->radius,
                                     broadcast<1>(a0->velocity + s * (a1->velocity - a0->velocity)),
                                     broadcast<1>(capsules.spin[a].spin),
                                     broadcast<1>(b0->velocity + t * (b1->velocity - b0->velocity)),
                                     broadcast<1>(capsules.spin[b].spin)};
    };
    const auto point = [](const ContactForce<Pack<1>>& f, double s, double t) {
        return PointForce{lane(f.on_1, 0), lane(f.moment, 0), s, t, f.arm_1[0], f.arm_2[0]};
    };
    ContactLaw smooth = law_;
    smooth.friction = ContactFriction::none;
    Ends ends;
    double elsewhere = 0;
    Vec3<Pack<1>> none = broadcast<1>(Vec3d{0, 0, 0});
    for (int i = 0; i < 2; ++i) {
        const double s = i == 0 ? first : last, t = std::clamp(dot(a0->position + s * d1 - b0->position, d2) / dot(d2, d2), 0.0, 1.0);
        const auto f = contact_force(smooth, at(s, t), h, none, Pack<1>(0.5 * share));
        elsewhere += f.normal[0];
        ends.at[i] = point(f, s, t);
    }
    // The nearest point again, with what is left of the normal force and all of the friction.
    const double s = force_[pair].s, t = force_[pair].t;
    Vec3<Pack<1>> spring = broadcast<1>(spring_before(capsules, pair, s, t));
    force_[pair] = point(contact_force(law_, at(s, t), h, spring, Pack<1>(1 - share), Pack<1>(elsewhere)), s, t);
    spring_[pair] = lane(spring, 0);
    active_[pair] |= side_by_side;
    block.ends.push_back({pair, ends});
}

void Contacts::gather(const Capsules& capsules, std::size_t rod, ContactLoads& loads) const {
    const auto first = static_cast<std::size_t>(capsules.first_slot[rod]), behind = static_cast<std::size_t>(capsules.first_slot[rod + 1]);
    for (std::size_t slot = first; slot < behind; ++slot) loads.force[slot] = loads.couple[slot] = {0, 0, 0};
    const auto take = [&](std::size_t slot, const PointForce& f, bool second) {
        const Vec3d force = second ? -f.force : f.force;
        const double share = second ? f.t : f.s;
        loads.force[slot] += (1 - share) * force;
        loads.force[slot + 1] += share * force;
        loads.couple[slot] += (second ? f.arm_b : f.arm_a) * f.moment;
    };
    const auto take_all = [&](std::size_t slot, std::size_t pair, bool second) {
        if (!active_[pair]) return;
        take(slot, force_[pair], second);
        if (!(active_[pair] & side_by_side)) return;
        const auto& ends = blocks_[pair / block_size].ends;
        const auto at = std::lower_bound(ends.begin(), ends.end(), pair, [](const auto& entry, std::size_t p) { return entry.first < p; });
        for (const PointForce& f : at->second.at) take(slot, f, second);
    };
    for (std::size_t slot = first; slot + 1 < behind; ++slot) {
        for (std::size_t i = reverse_begin_[slot]; i < reverse_begin_[slot + 1]; ++i) take_all(slot, reverse_[i], true);
        for (std::size_t i = candidates_.first[slot]; i < candidates_.first[slot + 1]; ++i) take_all(slot, i, false);
    }
}

void Contacts::evaluate(const Capsules& capsules, double h, ContactLoads& loads) {
    if (list_is_used_up(capsules)) renew_list(capsules);
    ++age_;
    std::swap(spring_, last_spring_);
    std::swap(active_, was_active_);
    blocks_.resize(blocks_of(pairs_.size()));
    for_blocks(threads_, pairs_.size(), [&](std::size_t begin, std::size_t end, std::size_t block) { meet(capsules, h, begin, end, blocks_[block]); });
    loads.force.resize(capsules.slots());
    loads.couple.resize(capsules.slots());
    const std::size_t rods = capsules.first_slot.size() - 1;
    constexpr std::size_t rods_per_task = 64;
    threads_.for_each((rods + rods_per_task - 1) / rods_per_task, [&](std::size_t task, int) {
        for (std::size_t rod = task * rods_per_task; rod < std::min(rods, (task + 1) * rods_per_task); ++rod) gather(capsules, rod, loads);
    });
    figures_.listed = static_cast<std::int64_t>(pairs_.size());
    figures_.active = 0;
    figures_.deepest = 0;
    for (const Block& block : blocks_) figures_.active += block.active, figures_.deepest = std::max(figures_.deepest, block.deepest);
}

std::vector<Contact> Contacts::active() const {
    std::vector<Contact> all;
    for (std::size_t i = 0; i < pairs_.size(); ++i)
        if (active_[i]) all.push_back({pairs_[i], force_[i].s, force_[i].t, force_[i].force, overlap_[i]});
    return all;
}

} // namespace skein
