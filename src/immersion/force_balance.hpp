// Rods that feel the fluid: within a stage each slot has the fluid's push and a drag that is linear in its own
// velocity, which steps of rods take implicitly; then markers are forced to the mean velocities of the stage, and what
// they give the fluid beyond what rods received is owed to the rods in the next stage. Momentum of fluid and rods is
// kept to rounding.       theory.md (88)-(91)
#pragma once

#include "immersion/direct_forcing.hpp"
#include "immersion/fluid_loads.hpp"
#include "immersion/immersed_rods.hpp"
#include "immersion/inertia_in_fluid.hpp"
#include "parallel/communicator.hpp"
#include "skein/core/index.hpp"

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace skein {

class ForceBalance {
public:
    struct Fluid {
        double density, cell_volume; ///< kg/m^3, m^3
        double passing; ///< s: its steps at the Courant number for which shares that are returned were found
    };
    /// `weight`: acceleration by gravity of a group at a time, m/s^2.
    using Weight = std::function<Vec3d(std::size_t group, double time)>;
    ForceBalance(std::span<const RodGroup> groups, std::vector<std::shared_ptr<const InertiaInFluid>> inertia,
                 const ImmersedRods& rods, std::shared_ptr<FluidLoads> loads, const Fluid& fluid, Weight weight);

    /// Part of a step of the fluid, s.
    struct Stage {
        double begin, length, step; ///< s; `step`: of the whole step
    };
    /// Rods are about to begin a step of the fluid.
    void begin_step(double lag);
    /// Loads of a stage that begins, by what markers of own rods answer to the fluid.
    using Answer = std::function<DirectForcing::Answer(std::size_t marker)>;
    void begin_stage(const Stage& stage, double lag, const Answer& answer);
    /// Rods have come to its end: sets velocities of markers to the means since it began.
    void find_mean_velocities(double length, double lag, std::span<Vec3d> velocities);
    /// What was changed at markers is set against what rods received.
    void end_stage(std::span<const Vec3d> changes);
    /// Rods have come to the end of a step of the fluid.
    void end_step(double lag);

    /// Momentum of own rods less what the fluid bears for them, and what is on the way between both; kg m/s. By slot.
    std::vector<Vec3d> momentum(double lag) const;

    /// Of a slot: what it is owed and what is to be returned to it, node and element.
    static constexpr std::size_t record = 12;
    /// Records by slot of the scene, of all ranks. Collective.
    std::vector<double> saved(const Communicator& comm) const;
    std::size_t saved_numbers() const { return record * slots_of_scene_; }
    void restore(std::span<const double> kept);
    std::uint64_t digest() const;

private:
    struct Slots {
        Vec3d owed{0, 0, 0};      ///< N s, lab: impulse that the node has yet to receive
        Vec3d owed_turn{0, 0, 0}; ///< N m s, lab: of the element
        Vec3d lent{0, 0,
                   0}; ///< N s, lab: what added inertia has taken of the node's momentum, and returns step by step
        Vec3d lent_turn{0, 0, 0}; ///< N m s, lab: of the element
    };
    void move_fluid_within();
    /// Returned in this step: where that is not all, in proportion to the step.
    double returned(double share) const { return share < 1 ? pace_ * share : 1; }
    Vec3d returned(const Vec3d& shares) const { return {returned(shares.x), returned(shares.y), returned(shares.z)}; }
    const LocalRod& own(std::size_t i) const { return rods_.rods().local()[i]; }
    const RodGroup& group_of(std::size_t i) const { return nth(groups_, own(i).group); }
    const InertiaInFluid& inertia_of(std::size_t i) const { return *nth(inertia_, own(i).group); }
    std::array<double, record> numbers_of(std::size_t slot) const;
    std::int64_t first_in_scene(std::size_t i) const;

    std::span<const RodGroup> groups_;
    const ImmersedRods& rods_;
    std::shared_ptr<FluidLoads> loads_;
    Fluid fluid_;
    double pace_ = 1; ///< of the step over the fluid's `passing`, at most 1
    Weight weight_;
    std::vector<std::shared_ptr<const InertiaInFluid>> inertia_; ///< by group
    std::vector<std::int64_t> first_slot_;                       ///< of a group's rods among slots of the scene
    std::size_t slots_of_scene_ = 0;
    std::vector<Slots> slots_;           ///< as loads_ has them
    std::vector<Vec3d> velocity_, spin_; ///< by slot, at the begin of the step
    std::vector<Vec3d> own_push_,
        own_turn_; ///< by slot: of the loads, what is not the fluid's; N, N m, over the stage N s, N m s
    std::vector<Vec3d> place_, off_; ///< of markers at the begin of the stage, m, lab; the second off the axis
};

} // namespace skein
