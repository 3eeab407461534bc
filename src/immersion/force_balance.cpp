#include "immersion/force_balance.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace skein {

namespace {

double mean_of(const Vec3d& a) { return (a.x + a.y + a.z) / 3; }

} // namespace

ForceBalance::ForceBalance(std::span<const RodGroup> groups, std::vector<std::shared_ptr<const InertiaInFluid>> inertia,
                           const ImmersedRods& rods, std::shared_ptr<FluidLoads> loads, const Fluid& fluid,
                           Weight weight)
    : groups_(groups), rods_(rods), loads_(std::move(loads)), fluid_(fluid), weight_(std::move(weight)),
      inertia_(std::move(inertia)), slots_(loads_->load.size()), velocity_(slots_.size()), spin_(slots_.size()),
      own_push_(slots_.size()), own_turn_(slots_.size()), place_(rods.count()), off_(rods.count()) {
    std::int64_t first = 0;
    for (const RodGroup& group : groups_) {
        first_slot_.push_back(first);
        first += group.count() * group.slots();
    }
    slots_of_scene_ = static_cast<std::size_t>(first);
    move_fluid_within();
}

/// Where rods begin with velocities, the fluid within them does too: its momentum is on its way to them.
void ForceBalance::move_fluid_within() {
    rods_.read(0, [&](int, std::size_t i, const RodCopy& rod) {
        const RodGroup& group = group_of(i);
        const InertiaInFluid& inertia = inertia_of(i);
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            Slots& slot = slots_[loads_->first(i) + k];
            slot.owed = (inertia.of_nodes[k].borne * group.node_mass[k]) * lane(rod.state[k].velocity, 0);
            if (k < group.element.size())
                slot.owed_turn =
                    transpose_times(rod.frames[k], scale(inertia.of_elements[k].borne,
                                                         scale(group.element[k].inertia, lane(rod.state[k].spin, 0))));
        }
    });
}

std::int64_t ForceBalance::first_in_scene(std::size_t i) const {
    return nth(first_slot_, own(i).group) + own(i).index * group_of(i).slots();
}

void ForceBalance::begin_step(double lag) {
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            velocity_[loads_->first(i) + k] = lane(rod.state[k].velocity, 0);
            spin_[loads_->first(i) + k] = lane(rod.state[k].spin, 0);
        }
    });
}

void ForceBalance::begin_stage(const Stage& stage, double lag, const Answer& answer) {
    pace_ = std::min(1.0, stage.step / fluid_.passing);
    const double per_length = 1 / stage.length, share = stage.length / stage.step,
                 middle = stage.begin + 0.5 * stage.length;
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        const RodGroup& group = group_of(i);
        const InertiaInFluid& inertia = inertia_of(i);
        const std::size_t first = loads_->first(i), count = rod.state.size();
        const auto load = loads_->load.begin() + static_cast<std::ptrdiff_t>(first);
        std::fill_n(load, count, FluidLoad{});
        std::fill_n(loads_->received.begin() + static_cast<std::ptrdiff_t>(first), count, FluidImpulse{});
        rods_.for_markers(i, [&](std::size_t m, const RodMarker& marker) {
            place_[m] = ImmersedRods::place_of(marker, rod);
            off_[m] = ImmersedRods::off_axis(marker, rod.frames[marker.element]);
            const auto [volume, times_velocity] = answer(m);
            const Vec3d mass = fluid_.density * volume, impulse = fluid_.density * times_velocity;
            FluidLoad &before = load[marker.element], &behind = load[marker.element + 1];
            before.push += (1 - marker.along) * impulse;
            before.drag += (1 - marker.along) * mass;
            behind.push += marker.along * impulse;
            behind.drag += marker.along * mass;
            before.couple += cross(off_[m], impulse);
            const double across = mean_of(mass), along_d1 = marker.off_d1 * marker.off_d1,
                         along_d2 = marker.off_d2 * marker.off_d2;
            before.turn_drag += across * Vec3d{along_d2, along_d1, along_d1 + along_d2};
        });
        if (group.closed()) { // its last node is its first
            load[0].push += load[count - 1].push;
            load[0].drag += load[count - 1].drag;
            load[static_cast<std::ptrdiff_t>(count) - 1] = {};
        }
        const Vec3d buoyancy = (-inertia.displaced) * weight_(static_cast<std::size_t>(own(i).group), middle);
        for (std::size_t k = 0; k < count; ++k) {
            const Slots& slot = slots_[first + k];
            FluidLoad& of_slot = load[static_cast<std::ptrdiff_t>(k)];
            const double mass = group.node_mass[k];
            own_push_[first + k] =
                (mass * stage.length) * buoyancy + (share * returned(inertia.of_nodes[k].returned)) * slot.lent;
            of_slot.push = per_length * (of_slot.push + slot.owed + own_push_[first + k]);
            of_slot.drag = per_length * of_slot.drag;
            if (k == group.element.size()) break;
            own_turn_[first + k] =
                share * transpose_times(rod.frames[k], scale(returned(inertia.of_elements[k].returned),
                                                             rod.frames[k] * slot.lent_turn));
            of_slot.couple = per_length * (of_slot.couple + slot.owed_turn + own_turn_[first + k]);
            of_slot.turn_drag = per_length * of_slot.turn_drag;
        }
    });
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
        const std::size_t first = loads_->first(i), count = static_cast<std::size_t>(group.slots());
        for (std::size_t k = 0; k < count; ++k) {
            const FluidImpulse& received = loads_->received[first + k];
            slots_[first + k].owed += own_push_[first + k] - received.on_node;
            if (k < group.element.size()) slots_[first + k].owed_turn += own_turn_[first + k] - received.on_element;
        }
        rods_.for_markers(i, [&](std::size_t m, const RodMarker& marker) {
            const Vec3d given = (fluid_.density * fluid_.cell_volume) * changes[m];
            slots_[first + marker.element].owed -= (1 - marker.along) * given;
            slots_[first + marker.element + 1].owed -= marker.along * given;
            slots_[first + marker.element].owed_turn -= cross(off_[m], given);
        });
        if (group.closed()) {
            slots_[first].owed += slots_[first + count - 1].owed;
            slots_[first + count - 1].owed = {0, 0, 0};
        }
    }
}

void ForceBalance::end_step(double lag) {
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        const RodGroup& group = group_of(i);
        const InertiaInFluid& inertia = inertia_of(i);
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            const std::size_t at = loads_->first(i) + k;
            Slots& slot = slots_[at];
            slot.lent =
                (1 - returned(inertia.of_nodes[k].returned)) * slot.lent +
                (inertia.of_nodes[k].added * group.node_mass[k]) * (lane(rod.state[k].velocity, 0) - velocity_[at]);
            if (k == group.element.size()) break;
            const InertiaShares<Vec3d>& of_element = inertia.of_elements[k];
            const Vec3d lent = rod.frames[k] * slot.lent_turn, gained = lane(rod.state[k].spin, 0) - spin_[at];
            slot.lent_turn =
                transpose_times(rod.frames[k], lent - scale(returned(of_element.returned), lent) +
                                                   scale(of_element.added, scale(group.element[k].inertia, gained)));
        }
    });
}

std::vector<Vec3d> ForceBalance::momentum(double lag) const {
    std::vector<Vec3d> all(slots_.size());
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        const InertiaInFluid& inertia = inertia_of(i);
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            const Slots& slot = slots_[loads_->first(i) + k];
            const double mass = group_of(i).node_mass[k];
            all[loads_->first(i) + k] =
                (mass * (1 - inertia.of_nodes[k].borne)) * lane(rod.state[k].velocity, 0) + slot.lent + slot.owed;
        }
    });
    return all;
}

std::array<double, ForceBalance::record> ForceBalance::numbers_of(std::size_t slot) const {
    const Slots& s = slots_[slot];
    return {s.owed.x, s.owed.y, s.owed.z, s.owed_turn.x, s.owed_turn.y, s.owed_turn.z,
            s.lent.x, s.lent.y, s.lent.z, s.lent_turn.x, s.lent_turn.y, s.lent_turn.z};
}

std::vector<double> ForceBalance::saved(const Communicator& comm) const {
    std::vector<double> mine;
    for (std::size_t i = 0; i < rods_.rods().local().size(); ++i)
        for (std::size_t k = 0; k < static_cast<std::size_t>(group_of(i).slots()); ++k) {
            mine.push_back(static_cast<double>(first_in_scene(i) + static_cast<std::int64_t>(k)));
            const auto numbers = numbers_of(loads_->first(i) + k);
            mine.insert(mine.end(), numbers.begin(), numbers.end());
        }
    const std::vector<double> all = comm.all_gather(mine);
    std::vector<double> sorted(saved_numbers());
    for (std::size_t at = 0; at < all.size(); at += record + 1)
        std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(at) + 1, record,
                    sorted.begin() + static_cast<std::ptrdiff_t>(record * static_cast<std::size_t>(all[at])));
    return sorted;
}

void ForceBalance::restore(std::span<const double> kept) {
    for (std::size_t i = 0; i < rods_.rods().local().size(); ++i)
        for (std::size_t k = 0; k < static_cast<std::size_t>(group_of(i).slots()); ++k) {
            const double* n = kept.data() + record * (static_cast<std::size_t>(first_in_scene(i)) + k);
            slots_[loads_->first(i) + k] = {
                {n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]}, {n[9], n[10], n[11]}};
        }
}

std::uint64_t ForceBalance::digest() const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < rods_.rods().local().size(); ++i)
        for (std::size_t k = 0; k < static_cast<std::size_t>(group_of(i).slots()); ++k)
            sum += hash_numbers(first_in_scene(i) + static_cast<std::int64_t>(k), numbers_of(loads_->first(i) + k));
    return sum;
}

} // namespace skein
