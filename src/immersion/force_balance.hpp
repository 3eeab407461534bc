// Momentum balance of rods that feel the fluid (two-way coupling).                              theory.md (88)-(91)
//
//   node of a slot   (1 - beta) m v' = F + (1 - rho/rho_s) m g - J',   J = rho h^3 sum_m N_m du_m               (88)
//   end of a step    L = (1 - theta) L + m_A dv,   m_A = m_hat - (1 - beta) m                                  (88a)
//   in a stage       m_hat v' = F - (rho/rho_s) m g + (rho h^3 sum_m w_m N_m u_m - K v + D)/tau + (theta/h_t) L  (89)
//   end of a stage   D -= rho h^3 sum_m N_m du_m + integral over tau of the fluid's force in (89)               (90)
//   conserved        rho h^3 sum_x u + sum_slots((1 - beta) m v + L + D - S)                                    (91)
//
//   D      residual impulse            beta   displaced share of the inertia     w_m, u_m   response of marker m
//   L      momentum of the added mass  m_hat  effective mass                     N_m        its share in the slot
//   S      momentum relative to the axis, of sharp rods (155b)
//   theta  relaxation fraction         K      drag coefficient                   du_m       its change of velocity
//   h_t    length of a step            tau    length of a stage                  u          velocity of the fluid
//
// Elements have the same balance with moments of inertia, couples and spins. Steps of rods take the drag implicitly.
// The fluid within a body moves with it rigidly, so both balances of a body share its momentum, (140)-(142).
// Forces on the fluid and on the rods are equal and opposite, so (91) holds to rounding.
#pragma once

#include "immersion/direct_forcing.hpp"
#include "immersion/fluid_loads.hpp"
#include "immersion/immersed_rods.hpp"
#include "immersion/inertia_in_fluid.hpp"
#include "immersion/rigid_fit.hpp"
#include "immersion/sharp_forcing.hpp"
#include "parallel/communicator.hpp"
#include "skein/core/index.hpp"

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace skein {

/// Slots of this rank whose nodes are one: what they have of its loads. By the mass that kicks feel, implicit drags
/// take each of them, before it moves as one, to velocities whose mean is that of the one node. A body has all of what
/// nodes at its places would have, with the couples of it.
struct SharedNode {
    std::vector<std::size_t> slots;                ///< numbers in FluidLoads
    std::vector<double> shares;                    ///< sum 1
    std::function<bool(const Rods&)> is_torn = {}; ///< true where each keeps its own from now on; empty: it never tears
    std::vector<Vec3d> arms = {}; ///< of a body, the first slot: from its centre to the nodes, body axes, m
};

/// Momenta in transit between the fluid and one slot, lab components.
struct SlotExchange {
    Vec3d residual_impulse{0, 0, 0};         ///< D of the node, N s
    Vec3d residual_angular_impulse{0, 0, 0}; ///< D of the element, N m s
    Vec3d added_momentum{0, 0, 0};           ///< L of the node, N s
    Vec3d added_angular_momentum{0, 0, 0};   ///< L of the element, N m s
};

/// State of a slot of a rod with a sharp surface from its last stage, lab components.
struct SharpSlot {
    Vec3d relative{0, 0, 0};                          ///< S of the node, N s
    Vec3d mean_velocity{0, 0, 0}, mean_spin{0, 0, 0}; ///< of the node and the element, m/s, rad/s
};

class ForceBalance {
public:
    struct Fluid {
        double density;        ///< kg/m^3
        double cell_volume;    ///< m^3
        double reference_step; ///< s, step at the Courant number for which relaxation fractions were found
    };
    /// Acceleration by gravity of a group at a time, m/s^2.
    using Weight = std::function<Vec3d(std::size_t group, double time)>;
    ForceBalance(std::span<const RodGroup> groups, const ImmersedRods& rods, std::shared_ptr<FluidLoads> loads,
                 const Fluid& fluid, Weight weight, std::vector<SharedNode> shared = {});

    /// Stage of a step of the fluid: its begin, its length and the length of the whole step, s.
    struct Stage {
        double begin, length, step;
    };
    /// Responses of markers of own rods, by their number.
    using Responses = std::function<MarkerResponse(std::size_t marker)>;

    /// Responses of the elements of own rod i, which has a sharp surface.
    using SharpResponses = std::function<std::span<const SharpForcing::Response>(std::size_t i)>;
    using GivenByElements = std::function<std::span<const SharpForcing::GivenByElement>(std::size_t i)>;

    /// Momentum and moment of it that a body with a sharp surface gives the fluid, kg m/s, kg m^2/s.
    struct GivenBySurface {
        Vec3d linear, angular;
    };
    /// Saves the rates of rods at the begin of a step. `slip`: motion of the fluid within own body i, which has a sharp
    /// surface, relative to the body.
    void begin_step(double lag, const std::function<RigidMotion(std::size_t i)>& slip);
    /// Sets the loads of a stage by (89).
    void begin_stage(const Stage& stage, double lag, const Responses& responses, const SharpResponses& of_sharp);
    /// Takes back what rods have received in the stage, which they begin once more.
    void forget_received();
    /// Sets velocities of markers to their means over a stage of this length, s, at the end of which rods are, and
    /// finds those of nodes of rods with sharp surfaces.
    void find_mean_velocities(double length, double lag, std::span<Vec3d> velocities);
    /// Advances D by (90), from the changes of velocity at markers, and what own body i has given by a sharp surface.
    void end_stage(std::span<const Vec3d> changes, const std::function<GivenBySurface(std::size_t i)>& given,
                   const GivenByElements& given_by_rod);
    /// Advances L by (88a).
    void end_step(double lag);

    /// Terms of (91) of own slots, kg m/s.
    std::vector<Vec3d> momentum(double lag) const;

    /// Mean rates of a slot of own rod i in the last stage. The rod has a sharp surface.
    const SharpSlot& sharp_slot(std::size_t i, std::size_t k) const { return sharp_slot_[loads_->first(i) + k]; }

    /// Numbers of a slot in a checkpoint: its SlotExchange, and its SharpSlot if some rods have sharp surfaces.
    std::size_t record() const;
    /// Records of all slots of the scene, in their order. Collective.
    std::vector<double> saved(const Communicator& comm) const;
    std::size_t saved_numbers() const { return record() * slots_of_scene_; }
    void restore(std::span<const double> saved);
    std::uint64_t digest() const;

private:
    /// Quantities of a slot within one step.
    struct SlotStep {
        Vec3d velocity{0, 0, 0};            ///< m/s, lab, at the begin of the step
        Vec3d spin{0, 0, 0};                ///< rad/s, body, at the begin of the step
        Vec3d along{0, 0, 0};               ///< direction of a rod with a held end there, at the begin of the step
        Vec3d own_impulse{0, 0, 0};         ///< N s, part of the stage's load that fluid and markers do not exert
        Vec3d own_angular_impulse{0, 0, 0}; ///< N m s, same part of the couple
        Vec3d impulse{0, 0, 0};             ///< N s, of a body with a sharp surface in the whole step
        Vec3d angular_impulse{0, 0, 0};     ///< N m s, of it, lab
    };
    /// A slot of a rod with a sharp surface at the begin of a stage, its mean rates in the stage less those, and the
    /// drags of its element that rates of the next node and of other elements decide.
    struct SharpStage {
        Vec3d place, velocity; ///< m, m/s
        Mat3d frame;
        Vec3d spin;                       ///< rad/s, lab
        Vec3d gain, turn_gain;            ///< m/s; rad/s, lab
        Vec3d shared;                     ///< kg
        std::array<Vec3d, 2> turn_shared; ///< kg m^2, axes of the element: by the element before and the next one
    };
    /// Numbers of a slot in a checkpoint, of which `record()` are in use.
    using SlotRecord = std::array<double, (sizeof(SlotExchange) + sizeof(SharpSlot)) / sizeof(double)>;
    SlotRecord record_of(std::size_t slot) const;
    /// Sets the impulses of a body with a sharp surface for the whole step, (145).
    void begin_step_of_sharp(std::size_t i, const RodCopy& body, const RigidMotion& slip);
    /// Momentum that a body has besides the fluid within it, about its centre of mass, lab.
    struct BodyMomentum {
        Vec3d linear, angular; ///< kg m/s, kg m^2/s
    };
    /// A body at the begin of a step, and its frame and rates at the begin of a stage.
    struct BodyStep {
        BodyMomentum momentum;
        Mat3d frame, stage_frame;
        Vec3d stage_velocity, stage_spin; ///< m/s, lab; rad/s, body
    };
    BodyMomentum body_momentum(std::size_t i, const RodCopy& body) const;
    /// Momentum of the fluid within a body, about the body's centre of mass, lab.
    BodyMomentum inner_momentum(std::size_t i, const RodCopy& body) const;
    /// Adds what markers of a body exert by the velocities that its turning and its drift give them, as far as drags of
    /// (89) do not have it, (143).
    void add_cross_drags(std::size_t i, const RodCopy& body, const Responses& responses, FluidLoad& load) const;
    /// Advances L of a body by (142).
    void end_step_of_body(std::size_t i, const RodCopy& body);
    /// Sets D = beta m v: fluid within rods starts with their velocities.
    void start_inner_fluid();
    /// Adds the responses of the markers of local()[i] to its loads.
    void add_responses(std::size_t i, const RodCopy& rod, const Responses& responses, std::span<FluidLoad> load);
    /// Momentum of the added mass of own rod i over this mass, m/s, which a sharp surface returns at once, along a held
    /// rod as other momentum.
    Vec3d mean_added_velocity(std::size_t i) const;
    /// Momentum of the added mass of a slot that a step returns, N s.
    Vec3d returned(std::size_t i, std::size_t k, const Vec3d& mean) const;
    /// Adds the responses of the elements of a rod with a sharp surface to its loads.
    void add_sharp_responses(std::size_t i, const RodCopy& rod, std::span<const SharpForcing::Response> responses,
                             std::span<FluidLoad> load);
    void begin_sharp_stage(std::size_t i, const RodCopy& rod, std::span<const SharpForcing::Response> responses);
    /// Takes what the elements of own rod i, which has a sharp surface, have given off its residual impulses.
    void take_given(std::size_t i, std::span<const SharpForcing::GivenByElement> given);
    /// Gives each of the slots of shared nodes its part of a sum of theirs: members of SlotExchange or FluidLoad.
    template <class Slots, class Member> void share(Slots& of_slots, Member member) const;
    /// Gives bodies the loads of nodes at their places, and the residual impulses of these.
    void give_loads_to_bodies();
    void give_residuals_to_bodies();
    /// Adds D, buoyancy and the relaxation of L, and turns impulses over the stage into loads.
    void add_impulses(std::size_t i, const RodCopy& rod, const Stage& stage, std::span<FluidLoad> load);
    /// Relaxation fraction theta of the present step, in proportion to its length below 1.
    double theta(double fraction) const { return fraction < 1 ? pace_ * fraction : fraction; }
    Vec3d theta(const Vec3d& fraction) const { return {theta(fraction.x), theta(fraction.y), theta(fraction.z)}; }
    const LocalRod& own(std::size_t i) const { return rods_.rods().local()[i]; }
    const RodGroup& group_of(std::size_t i) const { return rods_.constants(i); }
    const InertiaInFluid& inertia_of(std::size_t i) const { return rods_.inertia(i); }
    /// body(number in the scene, number on this rank) of each own slot.
    template <class Body> void for_slots(Body&& body) const;

    std::span<const RodGroup> groups_;
    const ImmersedRods& rods_;
    std::shared_ptr<FluidLoads> loads_;
    Fluid fluid_;
    double pace_ = 1;   ///< length of the step over the reference step, at most 1
    double length_ = 0; ///< of the step, s
    Weight weight_;
    std::vector<SharedNode> shared_;
    std::vector<std::int64_t> first_slot_; ///< by group: its first slot in the scene
    std::size_t slots_of_scene_ = 0;
    std::vector<SlotExchange> exchange_;  ///< by own slot, in the order of loads_
    std::vector<SharpSlot> sharp_slot_;   ///< by own slot; empty without rods with sharp surfaces
    std::vector<SlotStep> step_;          ///< by own slot
    std::vector<BodyStep> body_step_;     ///< by own slot; empty without bodies
    std::vector<SharpStage> sharp_stage_; ///< by own slot; empty without rods with sharp surfaces
    std::vector<Vec3d> place_, off_; ///< by marker at the begin of the stage: place and distance from the axis, m, lab
};

} // namespace skein
