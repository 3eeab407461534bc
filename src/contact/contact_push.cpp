// The forces of a block's contacts, and the slots and strips that these go to.
#include "contact/work_area.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <bit>

namespace skein {

using detail::across, detail::between, detail::edge;

/// A contact that touched in the step before does so no longer: the energy of its spring is lost.
void Contacts::end_contact(const Work& work, std::uint32_t pair) {
    if (work.bodies.owns_slot(list_.pair[pair].a)) work.figures.friction_work.add(memory_[pair].energy(), bins_);
    memory_[pair] = {};
    status_[pair] = 0;
}

/// Adds loads to the nodes of an element of an own body, or defers them: to the first with the couple on the element,
/// to the second. Share and arm of these rows need not be set.
template <class Row> void Contacts::exert(const Work& work, std::uint32_t slot, const Row& first, const Row& second) {
    const std::int32_t window = work.bodies.window_of[slot];
    if (!work.bodies.owns(static_cast<std::size_t>(window))) return;
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

/// A force on a node of an element, its start or its end.
void Contacts::exert_at(const Work& work, std::uint32_t slot, const ForceRow& row, bool at_end) {
    const std::int32_t window = work.bodies.window_of[slot];
    if (!work.bodies.owns(static_cast<std::size_t>(window))) return;
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

void Contacts::push_touching(const Work& work, const WorkArea& area, Sums& sums) {
    using A = WorkArea;
    constexpr int W = A::W;
    using P = Pack<W>;
    const P one(1.0), none(0.0);
    const ExposedMotion* const motion = work.bodies.motion.data();
    const std::int32_t* const window = work.bodies.window_of.data();
    const std::uint8_t* const own = work.bodies.own.empty() ? nullptr : work.bodies.own.data();
    std::uint8_t *const status = status_.data(), *const touched = touched_.data();
    ContactMemory<double>* const kept = memory_.data();
    ExertedLoad* const load = work.load;
    const std::uint32_t behind = work.last_slot;
    for (std::uint32_t i = 0; i < area.count; i += W) {
        const int count = static_cast<int>(std::min<std::uint32_t>(W, area.count - i));
        const std::uint32_t* const index = area.index.data() + i;
        const Pair* const pair = area.pair.data() + i;
        const auto rate = [&](auto&& of) {
            return load_transposed<W>([&](int l) { return &of(pair[l])->velocity.x; }).vector;
        };
        const auto spin = [&](auto&& of) {
            return load_transposed<W>([&](int l) { return &of(pair[l])->spin.x; }).vector;
        };
        const P s = area.pack(A::s, i), t = area.pack(A::t, i), radius_1 = area.pack(A::radius_1, i),
                radius_2 = area.pack(A::radius_2, i), weight = area.pack(A::weight, i),
                weight_of_all = area.pack(A::weight_of_all, i);
        const auto remembered = [&]() __attribute__((always_inline)) {
            const auto spring = load_transposed<W>([&](int l) { return &kept[index[l]].spring.x.x; });
            const auto viscous_part = load_transposed<W>([&](int l) { return &kept[index[l]].viscous_part.x; });
            return ContactMemory<P>{{spring.vector, spring.behind}, viscous_part.vector, viscous_part.behind};
        };
        const Vec3<P> no{none, none, none};
        ContactMemory<P> memory = remembers_ ? remembered() : ContactMemory<P>{{no, none}, no, none};
        const P distance = sqrt(area.pack(A::squared, i)), smaller = min(radius_1, radius_2),
                some = max(distance, P(1e-150));
        const P inverse = one / (some * smaller); // one division for two
        Vec3<P> normal = (smaller * inverse) * Vec3<P>{area.pack(A::x, i), area.pack(A::y, i), area.pack(A::z, i)};
        if (const auto met = distance < P(1e-150); any(met))
            for (int l = 0; l < count; ++l)
                if (met[l])
                    set_lane(normal, l,
                             lane(across<1>(broadcast<1>(edge(work.bodies, pair[l].a)),
                                            broadcast<1>(edge(work.bodies, pair[l].b))),
                                  0));
        const ContactState<P> state{
            normal,
            distance,
            radius_1,
            radius_2,
            between(rate([&](Pair p) { return motion + p.a; }), rate([&](Pair p) { return motion + p.a + 1; }), s),
            spin([&](Pair p) { return motion + p.a; }),
            between(rate([&](Pair p) { return motion + p.b; }), rate([&](Pair p) { return motion + p.b + 1; }), t),
            spin([&](Pair p) { return motion + p.b; })};
        const ContactForce<P> force = contact_force<W>(kinds_, numbers<W>(work.bodies, pair), state, work.h, memory,
                                                       {weight, weight_of_all}, area.pack(A::elsewhere, i));

        alignas(64) LoadRow row[W];
        store_transposed<W>(force.on_1, t, [&](int l) { return &row[l].number[0]; });
        store_transposed<W>(force.moment, force.arm_2, [&](int l) { return &row[l].number[4]; });
        struct {
            alignas(64) double first_1[W], second_1[W], arm_1[W], first_2[W];
        } share;
        detail::put(share.first_1, one - s);
        detail::put(share.second_1, s);
        detail::put(share.arm_1, force.arm_1);
        detail::put(share.first_2, t - one);
        const unsigned shared = bits_of(weight_of_all > none); // near-parallel pairs may have no share
        if (remembers_) {
            if (count == W) {
                store_transposed<W>(memory.spring.x, memory.spring.stiffness,
                                    [&](int l) { return &kept[index[l]].spring.x.x; });
                store_transposed<W>(memory.viscous_part, memory.weight,
                                    [&](int l) { return &kept[index[l]].viscous_part.x; });
            } else {
                for (int l = 0; l < count; ++l)
                    kept[index[l]] = {{lane(memory.spring.x, l), memory.spring.stiffness[l]},
                                      lane(memory.viscous_part, l),
                                      memory.weight[l]};
            }
            for (unsigned without = ~shared & ((1u << count) - 1); without != 0; without &= without - 1)
                kept[index[std::countr_zero(without)]] = {};
        }

        unsigned mine = (1u << count) - 1; // by first bodies
        for (int l = 0; l < count; ++l) {
            const Pair both = pair[l];
            const std::int32_t first = window[both.a], second = window[both.b];
            status[index[l]] = static_cast<std::uint8_t>((shared >> l & 1) * touching);
            const Pack<8> all = detail::pack_at<8>(&row[l]);
            if (!own || own[first]) {
                add_row(load + both.a, all, share.first_1[l], share.second_1[l], share.arm_1[l]);
                touched[first] = 1;
            } else {
                mine &= ~(1u << l);
            }
            if (own && !own[second]) continue;
            const double t_here = row[l].number[3], arm_2 = row[l].number[7];
            if (both.b < behind) {
                add_row(load + both.b, all, share.first_2[l], -t_here, arm_2);
                touched[second] = 1;
            } else {
                const double* f = row[l].number;
                work.deferring.defer(second, both.b, {-f[0], -f[1], -f[2], t_here, f[4], f[5], f[6], arm_2});
            }
        }
        sums.add(force, P(0.5) * (radius_1 + radius_2 - distance) * (some * inverse), weight_of_all, mine);
        work.figures.active += std::popcount(mine & shared);
    }
}

/// What these pairs remember, for a step that may begin anew: pairs that do not touch remember nothing.
void Contacts::keep_aside(std::uint32_t begin, std::uint32_t end) {
    std::copy(status_.data() + begin, status_.data() + end, status_before_.data() + begin);
    for (std::uint32_t first = begin; first < end; first += 8)
        for (unsigned bits = bits_of_bytes(&status_[first]); bits != 0; bits &= bits - 1)
            if (const std::uint32_t pair = first + static_cast<std::uint32_t>(std::countr_zero(bits)); pair < end)
                memory_before_[pair] = memory_[pair];
}

void Contacts::take_back(std::uint32_t begin, std::uint32_t end) {
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
    const std::uint32_t begin = list_.first[block.first_slot], end = list_.first[block.last_slot];
    if (begin == end) return;
    if (may_repeat_) keep_aside(begin, end);
    work.prune ? find_touching<true>(work, area) : find_touching<false>(work, area);
    follow_springs(work, area);
    for (const std::uint32_t pair : area.ended) end_contact(work, pair);
    Sums sums{bins_};
    push_vertices(work, area, sums);
    if (area.sides > 0) push_sides(work, area, sums);
    area.fill_up();
    push_touching(work, area, sums);
    sums.give(work.figures);
    if (!box_pairs_.empty()) push_boxes(work, area);
    if (watches_ && !area.deep.empty()) note_side_changes(work.bodies, area.deep);
}

/// Each strip from its last block to its first.
void Contacts::work_through(const Exposure& bodies, double h, std::span<const std::uint32_t> strips, bool prune,
                            std::span<ExertedLoad> loads) {
    threads_.for_each(strips.size(), [&](std::size_t i, int thread) {
        const ContactStrip& strip = deferred_.strips()[strips[i]];
        std::unique_ptr<WorkArea>& area = nth(area_, thread);
        if (!area) area = std::make_unique<WorkArea>();
        DeferredLoads::Deferring deferring(deferred_, strips[i], nth(next_, thread));
        for (std::size_t b = strip.last_block; b-- > strip.first_block;) {
            push({bodies, h, deferred_.blocks()[b], strip.last_slot, deferring, block_figures_[b], loads.data(), b,
                  prune},
                 *area);
            threads_.poll();
        }
    });
}

void Contacts::add_deferred(const Exposure& bodies, std::span<ExertedLoad> loads) {
    if (deferred_.strips().size() < 2) return;
    threads_.for_each(deferred_.blocks().size(), [&](std::size_t block, int) {
        deferred_.add_deferred(block, [&](std::uint32_t slot, const LoadRow& row) {
            add_row(&loads[slot], row);
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
