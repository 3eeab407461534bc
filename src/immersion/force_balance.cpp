#include "immersion/force_balance.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace skein {

using SlotRecord = std::array<double, ForceBalance::record>;

ForceBalance::ForceBalance(std::span<const RodGroup> groups, std::vector<std::shared_ptr<const InertiaInFluid>> inertia,
                           const ImmersedRods& rods, std::shared_ptr<FluidLoads> loads, const Fluid& fluid,
                           Weight weight, std::vector<SharedNode> shared)
    : groups_(groups), rods_(rods), loads_(std::move(loads)), fluid_(fluid), weight_(std::move(weight)),
      shared_(std::move(shared)), inertia_(std::move(inertia)), exchange_(loads_->load.size()), step_(exchange_.size()),
      place_(rods.count()), off_(rods.count()) {
    std::int64_t first = 0;
    for (const RodGroup& group : groups_) {
        first_slot_.push_back(first);
        first += group.count() * group.slots();
    }
    slots_of_scene_ = to_index(first);
    start_inner_fluid();
}

void ForceBalance::start_inner_fluid() {
    rods_.read(0, [&](int, std::size_t i, const RodCopy& rod) {
        const RodGroup& group = group_of(i);
        const InertiaInFluid& inertia = inertia_of(i);
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            SlotExchange& slot = exchange_[loads_->first(i) + k];
            slot.residual_impulse =
                (inertia.of_nodes[k].displaced * group.node_mass[k]) * lane(rod.state[k].velocity, 0);
            if (k == group.element.size()) break;
            slot.residual_angular_impulse =
                transpose_times(rod.frames[k], scale(inertia.of_elements[k].displaced,
                                                     scale(group.element[k].inertia, lane(rod.state[k].spin, 0))));
        }
    });
}

void ForceBalance::begin_step(double lag) {
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            SlotStep& slot = step_[loads_->first(i) + k];
            slot.velocity = lane(rod.state[k].velocity, 0);
            slot.spin = lane(rod.state[k].spin, 0);
        }
    });
}

void ForceBalance::begin_stage(const Stage& stage, double lag, const Responses& responses) {
    pace_ = std::min(1.0, stage.step / fluid_.reference_step);
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        const auto load = std::span(loads_->load).subspan(loads_->first(i), rod.state.size());
        const auto received = std::span(loads_->received).subspan(loads_->first(i), rod.state.size());
        std::fill(load.begin(), load.end(), FluidLoad{});
        std::fill(received.begin(), received.end(), FluidImpulse{});
        add_responses(i, rod, responses, load);
        if (group_of(i).closed()) { // its last node is its first
            load.front().push += load.back().push;
            load.front().drag += load.back().drag;
            load.back() = {};
        }
        add_impulses(i, rod, stage, load);
    });
    share(loads_->load, &FluidLoad::push);
    share(loads_->load, &FluidLoad::drag);
}

void ForceBalance::forget_received() { std::fill(loads_->received.begin(), loads_->received.end(), FluidImpulse{}); }

template <class Slots, class Member> void ForceBalance::share(Slots& of_slots, Member member) const {
    for (const SharedNode& node : shared_) {
        if (node.is_torn && node.is_torn(rods_.rods())) continue;
        Vec3d sum{0, 0, 0};
        for (const std::size_t slot : node.slots) sum += of_slots[slot].*member;
        for (std::size_t i = 0; i < node.slots.size(); ++i) of_slots[node.slots[i]].*member = node.shares[i] * sum;
    }
}

void ForceBalance::add_responses(std::size_t i, const RodCopy& rod, const Responses& responses,
                                 std::span<FluidLoad> load) {
    rods_.for_markers(i, [&](std::size_t m, const RodMarker& marker) {
        place_[m] = ImmersedRods::place_of(marker, rod);
        off_[m] = ImmersedRods::off_axis(marker, rod.frames[marker.element]);
        const MarkerResponse response = responses(m);
        const Vec3d mass = fluid_.density * response.volume, impulse = fluid_.density * response.impulse;
        FluidLoad &start = load[marker.element], &end = load[marker.element + 1];
        start.push += (1 - marker.along) * impulse;
        start.drag += (1 - marker.along) * mass;
        end.push += marker.along * impulse;
        end.drag += marker.along * mass;
        start.couple += cross(off_[m], impulse);
        const double mean_mass = (mass.x + mass.y + mass.z) / 3, squared_d1 = marker.off_d1 * marker.off_d1,
                     squared_d2 = marker.off_d2 * marker.off_d2;
        start.turn_drag += mean_mass * Vec3d{squared_d2, squared_d1, squared_d1 + squared_d2};
    });
}

void ForceBalance::add_impulses(std::size_t i, const RodCopy& rod, const Stage& stage, std::span<FluidLoad> load) {
    const RodGroup& group = group_of(i);
    const InertiaInFluid& inertia = inertia_of(i);
    const double per_length = 1 / stage.length, share = stage.length / stage.step;
    const Vec3d buoyancy = (-inertia.density_ratio) * weight_(to_index(own(i).group), stage.begin + 0.5 * stage.length);
    for (std::size_t k = 0; k < load.size(); ++k) {
        const SlotExchange& slot = exchange_[loads_->first(i) + k];
        SlotStep& step = step_[loads_->first(i) + k];
        step.own_impulse = (group.node_mass[k] * stage.length) * buoyancy +
                           (share * theta(inertia.of_nodes[k].relaxation)) * slot.added_momentum;
        load[k].push = per_length * (load[k].push + slot.residual_impulse + step.own_impulse);
        load[k].drag = per_length * load[k].drag;
        if (k == group.element.size()) break;
        step.own_angular_impulse =
            share * transpose_times(rod.frames[k], scale(theta(inertia.of_elements[k].relaxation),
                                                         rod.frames[k] * slot.added_angular_momentum));
        load[k].couple = per_length * (load[k].couple + slot.residual_angular_impulse + step.own_angular_impulse);
        load[k].turn_drag = per_length * load[k].turn_drag;
    }
}

void ForceBalance::find_mean_velocities(double length, double lag, std::span<Vec3d> velocities) {
    const double per_length = 1 / length;
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        rods_.for_markers(i, [&](std::size_t m, const RodMarker& marker) {
            velocities[m] = per_length * (ImmersedRods::place_of(marker, rod) - place_[m]);
        });
    });
}

void ForceBalance::end_stage(std::span<const Vec3d> changes) {
    for (std::size_t i = 0; i < rods_.rods().local().size(); ++i) {
        const RodGroup& group = group_of(i);
        const std::size_t first = loads_->first(i);
        const auto slots = std::span(exchange_).subspan(first, to_index(group.slots()));
        for (std::size_t k = 0; k < slots.size(); ++k) {
            const FluidImpulse& received = loads_->received[first + k];
            slots[k].residual_impulse += step_[first + k].own_impulse - received.on_node;
            if (k < group.element.size())
                slots[k].residual_angular_impulse += step_[first + k].own_angular_impulse - received.on_element;
        }
        rods_.for_markers(i, [&](std::size_t m, const RodMarker& marker) {
            const Vec3d given = (fluid_.density * fluid_.cell_volume) * changes[m];
            slots[marker.element].residual_impulse -= (1 - marker.along) * given;
            slots[marker.element + 1].residual_impulse -= marker.along * given;
            slots[marker.element].residual_angular_impulse -= cross(off_[m], given);
        });
        if (group.closed()) {
            slots.front().residual_impulse += slots.back().residual_impulse;
            slots.back().residual_impulse = {0, 0, 0};
        }
    }
    share(exchange_, &SlotExchange::residual_impulse);
}

void ForceBalance::end_step(double lag) {
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        const RodGroup& group = group_of(i);
        const InertiaInFluid& inertia = inertia_of(i);
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            SlotExchange& slot = exchange_[loads_->first(i) + k];
            const SlotStep& before = step_[loads_->first(i) + k];
            const InertiaShares<double>& of_node = inertia.of_nodes[k];
            slot.added_momentum =
                (1 - theta(of_node.relaxation)) * slot.added_momentum +
                (of_node.added * group.node_mass[k]) * (lane(rod.state[k].velocity, 0) - before.velocity);
            if (k == group.element.size()) break;
            const InertiaShares<Vec3d>& of_element = inertia.of_elements[k];
            const Vec3d old = rod.frames[k] * slot.added_angular_momentum,
                        gain = lane(rod.state[k].spin, 0) - before.spin;
            slot.added_angular_momentum =
                transpose_times(rod.frames[k], old - scale(theta(of_element.relaxation), old) +
                                                   scale(of_element.added, scale(group.element[k].inertia, gain)));
        }
    });
}

std::vector<Vec3d> ForceBalance::momentum(double lag) const {
    std::vector<Vec3d> all(exchange_.size());
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            const SlotExchange& slot = exchange_[loads_->first(i) + k];
            all[loads_->first(i) + k] = (group_of(i).node_mass[k] * (1 - inertia_of(i).of_nodes[k].displaced)) *
                                            lane(rod.state[k].velocity, 0) +
                                        slot.added_momentum + slot.residual_impulse;
        }
    });
    return all;
}

template <class Body> void ForceBalance::for_slots(Body&& body) const {
    for (std::size_t i = 0; i < rods_.rods().local().size(); ++i) {
        const std::int64_t slots = group_of(i).slots(), first = nth(first_slot_, own(i).group) + own(i).index * slots;
        for (std::int64_t k = 0; k < slots; ++k) body(first + k, loads_->first(i) + to_index(k));
    }
}

std::vector<double> ForceBalance::saved(const Communicator& comm) const {
    std::vector<double> mine;
    for_slots([&](std::int64_t in_scene, std::size_t slot) {
        mine.push_back(static_cast<double>(in_scene));
        const auto numbers = std::bit_cast<SlotRecord>(exchange_[slot]);
        mine.insert(mine.end(), numbers.begin(), numbers.end());
    });
    const std::vector<double> all = comm.all_gather(mine);
    std::vector<double> sorted(saved_numbers());
    for (std::size_t at = 0; at < all.size(); at += record + 1)
        std::copy_n(&all[at + 1], record, &sorted[record * static_cast<std::size_t>(all[at])]);
    return sorted;
}

void ForceBalance::restore(std::span<const double> saved) {
    for_slots([&](std::int64_t in_scene, std::size_t slot) {
        SlotRecord numbers;
        std::copy_n(&nth(saved, to_index(in_scene) * record), record, numbers.begin());
        exchange_[slot] = std::bit_cast<SlotExchange>(numbers);
    });
}

std::uint64_t ForceBalance::digest() const {
    std::uint64_t sum = 0;
    for_slots([&](std::int64_t in_scene, std::size_t slot) {
        sum += hash_numbers(in_scene, std::bit_cast<SlotRecord>(exchange_[slot]));
    });
    return sum;
}

} // namespace skein
