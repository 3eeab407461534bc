// The forces of a block's contacts, and the slots and strips that these go to.
#include "contact/contact_tangent.hpp"
#include "contact/work_area.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <bit>
#include <cassert>

namespace skein {

using detail::across, detail::between, detail::edge;

/// Ends a contact that touched in the step before. The energy of its spring is lost.
void Contacts::end_contact(const Work& work, std::uint32_t pair) {
    if (work.bodies.owns_slot(list_.pair[pair].a)) work.figures.friction_work.add(memory_[pair].energy(), bins_);
    memory_[pair] = {};
    status_[pair] = 0;
}

/// Adds loads to the nodes of an element of an own body, or defers them. The couple goes to the first node's row. Share
/// and arm of these rows need not be set.
template <class Row> void Contacts::exert(const Work& work, std::uint32_t slot, const Row& first, const Row& second) {
    const std::int32_t window = work.bodies.window_of[slot];
    if (!work.bodies.owns(to_index(window))) return;
    if (slot >= work.last_slot) {
        const auto with = [](const Row& of, double share, double arm) {
            LoadRow row = detail::as_load(of);
            row.number[3] = share;
            row.number[7] = arm;
            return row;
        };
        work.deferring.defer(window, slot, with(first, 0, 1));
        work.deferring.defer(window, slot, with(second, 1, 0));
        return;
    }
    add_whole_row(&work.load[slot], first);
    add_whole_row(&work.load[slot + 1], second);
    nth(touched_, window) = 1;
}

void Contacts::exert(const Work& work, std::uint32_t slot, const ElementLoad<double>& load) {
    const Vec3d &f = load.first, &g = load.second, &c = load.couple;
    exert(work, slot, LoadRow{f.x, f.y, f.z, 0, c.x, c.y, c.z, 0}, LoadRow{g.x, g.y, g.z, 0, 0, 0, 0, 0});
}

template void Contacts::exert(const Work& work, std::uint32_t slot, const LoadRow& first, const LoadRow& second);
template void Contacts::exert(const Work& work, std::uint32_t slot, const ForceRow& first, const ForceRow& second);

/// Adds or defers a force on the start or the end of an element.
void Contacts::exert_at(const Work& work, std::uint32_t slot, const ForceRow& row, bool at_end) {
    const std::int32_t window = work.bodies.window_of[slot];
    if (!work.bodies.owns(to_index(window))) return;
    if (slot >= work.last_slot) {
        LoadRow deferred = detail::as_load(row);
        deferred.number[3] = at_end;
        deferred.number[7] = 0;
        work.deferring.defer(window, slot, deferred);
        return;
    }
    add_whole_row(&work.load[slot + at_end], row);
    nth(touched_, window) = 1;
}

/// Adds or defers slopes of a contact of an own body's element.
void Contacts::stiffen(const Work& work, std::uint32_t slot, const PointTangent& tangent) {
    const std::int32_t window = work.bodies.window_of[slot];
    if (!tangent.acts() || !work.bodies.owns(to_index(window))) return;
    if (slot >= work.last_slot) return work.deferring.defer(window, slot, tangent);
    add(work.tangent[slot], tangent);
    nth(touched_, window) = 1;
}

/// Forces of pairs that touch, eight at a time: state, force, memory, loads on both elements in the order of pairs.
/// `zone`: pairs that are near enough to meet are among them, and act with slopes where these are wanted.
template <bool zone> class Contacts::TouchingForces {
public:
    TouchingForces(Contacts& contacts, const Work& work, const WorkArea& area)
        : contacts_(contacts), work_(work), area_(area), motion_(work.bodies.motion.data()),
          window_(work.bodies.window_of.data()), own_(work.bodies.own.empty() ? nullptr : work.bodies.own.data()),
          status_(contacts.status_.data()), touched_(contacts.touched_.data()), memory_(contacts.memory_.data()),
          load_(work.load), last_slot_(work.last_slot) {}

    SKEIN_INLINE void push(std::uint32_t i, Sums& sums) const {
        const Eight eight{area_.index.data() + i, area_.pair.data() + i,
                          static_cast<int>(std::min<std::uint32_t>(W, area_.count - i))};
        assert(eight.count > 0 && i + W <= area_.pair.size());
        const P s = area_.pack(A::s, i), t = area_.pack(A::t, i), share = area_.pack(A::weight_of_all, i);
        ContactMemory<P> memory;
        load(memory, eight);
        ContactState<P> now;
        const P inverse_radius = set_state(now, i, eight, s, t);
        const ContactNumbers<P> law = contacts_.numbers<W>(work_.bodies, eight.pair);
        const ContactWeight<P> weight{area_.pack(A::weight, i), share};
        const P elsewhere = area_.pack(A::elsewhere, i);
        const ContactForce<P> force = contact_force<W>(contacts_.kinds_, law, now, work_.h, memory, weight, elsewhere);
        Rows rows;
        fill(rows, force, s, t);
        const P overlap = now.radius_1 + now.radius_2 - now.distance;
        P counted = share;
        if constexpr (zone) counted = select(overlap > P(0.0), share, P(0.0)); // others are near enough to meet
        const unsigned shared = bits_of(counted > P(0.0));                     // near-parallel pairs may have no share
        if (contacts_.remembers_) store(memory, eight, shared);
        const unsigned mine = add_loads(rows, eight, shared);
        if constexpr (zone) {
            if (work_.tangent) {
                const ContactWeight<P> of_slope{select(overlap > P(0.0), weight.normal, P(1.0)), share};
                auto slopes = contact_slopes<W>(contacts_.kinds_, law, now, work_.h, force, of_slope, elsewhere,
                                                contacts_.scene_.meeting_zone);
                slopes.tangential += turning_slope(force.normal, now);
                add_tangents(now.normal, slopes, s, force.arm_1, t, force.arm_2, eight);
            }
            work_.figures.near += std::popcount(mine);
        }
        sums.add(force, P(0.5) * overlap * inverse_radius, counted, mine);
        work_.figures.active += std::popcount(mine & shared);
    }

private:
    using A = WorkArea;
    static constexpr int W = A::W;
    using P = Pack<W>;

    /// Pairs i to i + 7 of the work area, of which the first `count` are not repeated.
    struct Eight {
        const std::uint32_t* index; ///< in the list of candidates
        const Pair* pair;
        int count;
    };
    /// Loads by pair, and factors with which they act on nodes and elements.
    struct Rows {
        alignas(64) LoadRow row[W];
        alignas(64) double first_1[W], second_1[W], arm_1[W], first_2[W];
    };

    SKEIN_INLINE void load(ContactMemory<P>& memory, const Eight& eight) const {
        const P none(0.0);
        memory = {{{none, none, none}, none}, {none, none, none}, none};
        if (!contacts_.remembers_) return;
        const auto spring = load_transposed<W>([&](int l) { return &memory_[eight.index[l]].spring.x.x; }),
                   viscous = load_transposed<W>([&](int l) { return &memory_[eight.index[l]].viscous_part.x; });
        memory = {{spring.vector, spring.fourth}, viscous.vector, viscous.fourth};
    }

    SKEIN_INLINE P set_state(ContactState<P>& to, std::uint32_t i, const Eight& eight, const P& s, const P& t) const {
        const P radius_1 = area_.pack(A::radius_1, i), radius_2 = area_.pack(A::radius_2, i);
        const P distance = sqrt(area_.pack(A::squared, i)), smaller = min(radius_1, radius_2),
                some = max(distance, P(1e-150)), inverse = P(1.0) / (some * smaller); // one division for two
        Vec3<P> normal = (smaller * inverse) * Vec3<P>{area_.pack(A::x, i), area_.pack(A::y, i), area_.pack(A::z, i)};
        if (const auto met = distance < P(1e-150); any(met)) set_normal_of_crossed(eight, met, normal);
        const auto first = [](Pair p) { return p.a; };
        const auto second = [](Pair p) { return p.b; };
        to.normal = normal;
        to.distance = distance;
        to.radius_1 = radius_1;
        to.radius_2 = radius_2;
        to.velocity_1 = velocity(eight, first, s);
        to.spin_1 = spin(eight, first);
        to.velocity_2 = velocity(eight, second, t);
        to.spin_2 = spin(eight, second);
        return some * inverse;
    }
    template <class Slot> SKEIN_INLINE Vec3<P> velocity(const Eight& eight, Slot&& slot, const P& share) const {
        const auto of_node = [&](int next) {
            return load_transposed<W>([&](int l) { return &(motion_ + slot(eight.pair[l]))[next].velocity.x; }).vector;
        };
        return between(of_node(0), of_node(1), share);
    }
    template <class Slot> SKEIN_INLINE Vec3<P> spin(const Eight& eight, Slot&& slot) const {
        return load_transposed<W>([&](int l) { return &motion_[slot(eight.pair[l])].spin.x; }).vector;
    }
    /// Axes that intersect have a normal across both.
    void set_normal_of_crossed(const Eight& eight, const Mask<W>& met, Vec3<P>& normal) const {
        for (int l = 0; l < eight.count; ++l)
            if (met[l])
                set_lane(normal, l,
                         lane(across<1>(broadcast<1>(edge(work_.bodies, eight.pair[l].a)),
                                        broadcast<1>(edge(work_.bodies, eight.pair[l].b))),
                              0));
    }

    SKEIN_INLINE static void fill(Rows& rows, const ContactForce<P>& force, const P& s, const P& t) {
        const P one(1.0);
        store_transposed<W>(force.on_1, t, [&](int l) { return &rows.row[l].number[0]; });
        store_transposed<W>(force.moment, force.arm_2, [&](int l) { return &rows.row[l].number[4]; });
        detail::put(rows.first_1, one - s);
        detail::put(rows.second_1, s);
        detail::put(rows.arm_1, force.arm_1);
        detail::put(rows.first_2, t - one);
    }

    /// Pairs without a share remember nothing.
    SKEIN_INLINE void store(const ContactMemory<P>& memory, const Eight& eight, unsigned shared) const {
        if (eight.count == W) {
            store_transposed<W>(memory.spring.x, memory.spring.stiffness,
                                [&](int l) { return &memory_[eight.index[l]].spring.x.x; });
            store_transposed<W>(memory.viscous_part, memory.weight,
                                [&](int l) { return &memory_[eight.index[l]].viscous_part.x; });
        } else {
            for (int l = 0; l < eight.count; ++l) memory_[eight.index[l]] = lane(memory, l);
        }
        for (unsigned without = ~shared & ((1u << eight.count) - 1); without != 0; without &= without - 1)
            memory_[eight.index[std::countr_zero(without)]] = {};
    }

    /// Adds the loads of own bodies and defers those of other strips. Returns pairs whose first body is own, as bits.
    SKEIN_INLINE unsigned add_loads(const Rows& rows, const Eight& eight, unsigned shared) const {
        unsigned mine = (1u << eight.count) - 1;
        for (int l = 0; l < eight.count; ++l) {
            const Pair pair = eight.pair[l];
            const std::int32_t first = window_[pair.a], second = window_[pair.b];
            status_[eight.index[l]] = static_cast<std::uint8_t>((shared >> l & 1) * touching);
            const Pack<8> all = detail::pack_at<8>(&rows.row[l]);
            if (!own_ || own_[first]) {
                add_row(load_ + pair.a, all, rows.first_1[l], rows.second_1[l], rows.arm_1[l]);
                touched_[first] = 1;
            } else {
                mine &= ~(1u << l);
            }
            if (own_ && !own_[second]) continue;
            const double* const f = rows.row[l].number;
            const double t = f[3], arm_2 = f[7];
            if (pair.b < last_slot_) {
                add_row(load_ + pair.b, all, rows.first_2[l], -t, arm_2);
                touched_[second] = 1;
            } else {
                work_.deferring.defer(second, pair.b, LoadRow{-f[0], -f[1], -f[2], t, f[4], f[5], f[6], arm_2});
            }
        }
        return mine;
    }

    /// Adds the slopes of both elements.
    void add_tangents(const Vec3<P>& n, const ContactSlopes<P>& slopes, const P& s, const P& arm_1, const P& t,
                      const P& arm_2, const Eight& eight) const {
        const P p = P(own_share_of_tangents) * slopes.normal, q = P(own_share_of_tangents) * slopes.tangential;
        for (int l = 0; l < eight.count; ++l) {
            const auto [x, y, z] = lane(n, l);
            contacts_.stiffen(work_, eight.pair[l].a, {{x, y, z, p[l], q[l], s[l], arm_1[l], 0}});
            contacts_.stiffen(work_, eight.pair[l].b, {{x, y, z, p[l], q[l], t[l], -arm_2[l], 0}});
        }
    }

    Contacts& contacts_;
    const Work& work_;
    const WorkArea& area_;
    const ExposedMotion* const motion_;
    const std::int32_t* const window_;
    const std::uint8_t* const own_; ///< null where all bodies are own
    std::uint8_t *const status_, *const touched_;
    ContactMemory<double>* const memory_;
    ExertedLoad* const load_;
    const std::uint32_t last_slot_; ///< end of the strip
};

void Contacts::push_touching(const Work& work, const WorkArea& area, Sums& sums) {
    const auto push_all = [&](const auto& forces) {
        for (std::uint32_t i = 0; i < area.count; i += WorkArea::W) forces.push(i, sums);
    };
    if (work.tangent || scene_.meeting_zone > 0) push_all(TouchingForces<true>(*this, work, area));
    else push_all(TouchingForces<false>(*this, work, area));
}

/// Saves the memory of pairs for a step that may be repeated. Pairs that do not touch have none.
void Contacts::save_memory(std::uint32_t begin, std::uint32_t end) {
    std::copy(status_.data() + begin, status_.data() + end, status_before_.data() + begin);
    for (std::uint32_t first = begin; first < end; first += 8)
        for (unsigned bits = bits_of_bytes(&status_[first]); bits != 0; bits &= bits - 1)
            if (const std::uint32_t pair = first + static_cast<std::uint32_t>(std::countr_zero(bits)); pair < end)
                memory_before_[pair] = memory_[pair];
}

void Contacts::restore_memory(std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t pair = begin; pair < end; ++pair) {
        if (status_before_[pair] & touching) memory_[pair] = memory_before_[pair];
        else if (status_[pair] & touching) memory_[pair] = {};
        status_[pair] = status_before_[pair];
    }
}

void Contacts::push(const Work& work, WorkArea& area) {
    const ContactBlock& block = work.block;
    work.figures = {};
    if (!block.paired) return; // its bodies are marked as untouched since the list was made
    std::fill(touched_.begin() + block.first_window, touched_.begin() + block.last_window, std::uint8_t{0});
    std::fill(work.load + block.first_slot, work.load + block.last_slot, ExertedLoad{});
    if (work.tangent) std::fill(work.tangent + block.first_slot, work.tangent + block.last_slot, SlotTangent{});
    const std::uint32_t begin = list_.first[block.first_slot], end = list_.first[block.last_slot];
    if (begin == end) return;
    if (may_repeat_) save_memory(begin, end);
    work.prune ? find_touching<true>(work, area) : find_touching<false>(work, area);
    inherit_springs(work, area);
    for (const std::uint32_t pair : area.ended) end_contact(work, pair);
    Sums sums{bins_};
    push_vertices(work, area, sums);
    if (area.near_parallel_count > 0) push_near_parallel(work, area, sums);
    area.fill_up();
    push_touching(work, area, sums);
    sums.give(work.figures);
    if (!box_pairs_.empty()) push_boxes(work, area);
    if (watches_ && !area.deep.empty()) check_side_changes(work.bodies, area.deep);
}

/// Each strip from its last block to its first.
void Contacts::run_strips(const Exposure& bodies, double h, std::span<const std::uint32_t> strips, bool prune,
                          std::span<ExertedLoad> loads) {
    threads_.for_each(strips.size(), [&](std::size_t i, int thread) {
        const ContactStrip& strip = deferred_.strips()[strips[i]];
        std::unique_ptr<WorkArea>& area = nth(area_, thread);
        if (!area) area = std::make_unique<WorkArea>();
        DeferredLoads::Deferring deferring(deferred_, strips[i], nth(next_, thread));
        for (std::size_t b = strip.last_block; b-- > strip.first_block;) {
            push({bodies, h, deferred_.blocks()[b], strip.last_slot, deferring, block_figures_[b], loads.data(),
                  tangents_.empty() ? nullptr : tangents_.data(), b, prune},
                 *area);
            threads_.poll();
        }
    });
}

void Contacts::add_deferred(const Exposure& bodies, std::span<ExertedLoad> loads) {
    if (deferred_.strips().size() < 2) return;
    threads_.for_each(deferred_.blocks().size(), [&](std::size_t block, int) {
        deferred_.add_deferred(block, [&]<class Row>(std::uint32_t slot, const Row& row) {
            if constexpr (std::is_same_v<Row, LoadRow>) add_row(&loads[slot], row);
            else add(tangents_[slot], row);
            nth(touched_, bodies.window_of[slot]) = 1;
        });
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
        const PairContact c = evaluate_pair(bodies, i); // a spring pulls as it is: what has slid has shortened it
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
        all.push_back({pair, c.s, c.t, c.force, overlap, 2 * std::min(a0.radius, b0.radius), c.weight, at_a + arm_a,
                       normal, velocity(pair.a, c.s, arm_a) - velocity(pair.b, c.t, arm_b)});
    }
    return all;
}

} // namespace skein
