// Bodies at rest: their loads, and the exact slopes of these by displacements. theory.md (96)-(98)
//   slot      displacement of its node, lab, and turn of its element, body:   x + dx,  Q <- R(t) Q
//   loads     those of all passes of the plan over a body by itself, and of joints, at rates of 0
//   stiffness K = -d(loads)/d(dx, t) + [c]/2 on the turn of an element with couple c: the second derivative of the
//             energy along t -> R(t) Q, symmetric where loads have a potential
// Strains of elements are carried along: stresses are those of the carried strain, which a correction changes as its
// slopes say. Where the carried strain is that of the state, these are its own loads.
// Friction of walls acts from a state on in which its springs are known, over a step as contact/static_friction.hpp
// has. Joints count whole turns from a state whose memory of them is known.
#pragma once

#include "skein/core/vec3.hpp"
#include "skein/rod/slot.hpp"
#include "tiles/slot_coupling.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace skein {

/// Stiffness of a row of slots to those of its rod from two before it to two after it, round a ring.
struct StiffnessRow {
    static constexpr int reach = 2;
    std::array<StiffnessBlock, 2 * reach + 1> block{};

    StiffnessBlock& at(int offset) { return block[static_cast<std::size_t>(offset + reach)]; }
    const StiffnessBlock& at(int offset) const { return block[static_cast<std::size_t>(offset + reach)]; }
};

/// Loads by slot of all rods, one after another.
struct StaticLoads {
    SlotShare share;           ///< set by who asks; loads beyond it are not complete
    std::vector<Vec3d> force;  ///< at nodes, lab, N
    std::vector<Vec3d> couple; ///< at elements, body, N m
    /// Sums of the sizes of the loads that act there: what a balance is measured by.
    std::vector<double> force_size, couple_size;
    std::vector<StiffnessRow> row;       ///< empty where none is asked for
    std::vector<SlotCoupling> couplings; ///< by joints
};

/// A node that moves with others: it is at the place of `master`, or at `arm` of the body there.
struct CommonNode {
    std::size_t slot, master;
    bool on_body;
    Vec3d arm; ///< body, m
};

/// Stiffness of joints at their points, N/m, and of their turns, N m/rad.
struct JointStiffness {
    double along = 0, about = 0;
};

class StaticRods {
public:
    virtual ~StaticRods() = default;
    /// First slot of rod i among those of all rods of this rank; of one beyond the last, the number of slots.
    virtual std::size_t first_slot(std::size_t i) const = 0;
    virtual std::span<const CommonNode> common_nodes() const = 0;
    /// Sets the time at which loads, motors and ends are taken, s.
    virtual void set_time(double time) = 0;
    /// Puts moved ends to their places at that time.
    virtual void lead_ends(std::span<Slot<1>> state) const = 0;
    /// Strain nu of the elements as they are; 0 where a slot has none.
    virtual std::vector<Vec3d> strains(std::span<const Slot<1>> state) const = 0;
    virtual void evaluate(std::span<const Slot<1>> state, std::span<const Vec3d> carried, bool with_stiffness,
                          StaticLoads& out) = 0;
    /// Damping at rest, minus the derivative of the loads by rates: in `row` and `couplings` in place of stiffness,
    /// with what damps in kicks. The rates of a slot are the velocity of its node, lab, and the spin of its element,
    /// body.
    virtual void evaluate_damping(std::span<const Slot<1>> state, StaticLoads& out) = 0;
    /// Memory of joints in a state from which the next ones are no more than half a turn away; empty: at the start.
    virtual void set_joint_memory(std::span<const double> memory) = 0;
    /// The same memory at such a next state. `slips`: dry friction of joints gives way there beyond its limit.
    virtual std::vector<double> joint_memory_at(std::span<const Slot<1>> state, bool slips) = 0;
    /// Numbers of that memory which a run keeps for rod i, after those of its passes.
    virtual std::vector<double> joint_memory_of(std::size_t i) = 0;
    /// Takes them out of all numbers that a run keeps for the rod.
    virtual void set_joint_memory_of(std::size_t i, std::span<const double> numbers) = 0;
    virtual std::span<const double> joint_memory() const = 0;
    /// Motors of position that turn joints, and the angle of one at a time, rad: one of each axis, or a vector.
    virtual std::size_t turning_motors() const = 0;
    virtual Vec3d motor_angle(std::size_t i, double time) const = 0;
    /// The largest of all joints.
    virtual JointStiffness stiffest_joint() const = 0;
    virtual bool rubs() const = 0;       ///< friction of walls acts
    virtual bool joints_rub() const = 0; ///< dry friction of joints acts
    /// Friction of walls acts from here on, where it has memory: its springs are those of this state.
    virtual void set_reference(std::span<const Slot<1>> state) = 0;
    /// Leaves friction out for a while, or not.
    virtual void take_friction(bool acts) = 0;
    /// The springs become those that the last evaluation left; its state is to be the next reference.
    virtual void keep_springs() = 0;
    /// Memory of rod i at all walls: numbers of WallContacts. Empty where no wall acts.
    virtual std::vector<double> wall_memory(std::size_t i) const = 0;
    virtual void set_wall_memory(std::size_t i, std::span<const double> numbers) = 0;
};

} // namespace skein
