// Friction with memory at rest: the forces are those of one step of the contact solver, which goes from a state where
// the springs of friction are known to the present one.                                               theory.md (106)
//   places     x of the step's end;  rates  (x - x_0)/H, log(Q Q_0^T)/H
//   H          so long that dashpots exert nothing, and that friction which depends on the speed of slip vanishes
//   stiffness  that of the law between two elements, over dual numbers; shares of vertices stay as they are
//   damping    the same by rates, over a step of no length, with dashpots
#pragma once

#include "contact/attached_slot.hpp"
#include "contact/contact_solver.hpp"
#include "core/rotation.hpp"
#include "skein/rod/slot.hpp"
#include "tiles/slot_coupling.hpp"

#include <span>
#include <vector>

namespace skein {

struct StaticContactLoads;
enum class Slopes;

/// Length of such a step, s.
inline constexpr double long_step = 1e12;
/// Sets the rates with which a rod comes to its state from `then` in such a step.
inline void set_rates_from(std::span<const Slot<1>> then, std::span<Slot<1>> state) {
    constexpr double rate = 1 / long_step;
    for (std::size_t k = 0; k < state.size(); ++k) {
        Slot<1>& now = state[k];
        set_lane(now.velocity, 0, rate * (lane(now.position, 0) - lane(then[k].position, 0)));
        set_lane(now.spin, 0, rate * relative_rotation(lane(now.director, 0), lane(then[k].director, 0)));
    }
}

class StaticFriction {
public:
    StaticFriction(const ContactScene& scene, std::span<const RodGroup> groups, std::span<const LocalRod> rods,
                   const Threads& threads);

    /// True from set_reference() on, where the law has friction with memory: without, all forces are normal ones.
    bool acts() const { return !reference_.empty(); }
    /// State in which the springs are known, slots of all bodies.
    void set_reference(std::span<const Slot<1>> state) {
        if (scene_.laws.friction() == ContactFriction::memory) reference_.assign(state.begin(), state.end());
    }
    /// The springs become those that the last evaluation left.
    void keep_springs() { springs_ = left_; }
    const std::vector<SavedContact>& springs() const { return springs_; }
    void set_springs(std::vector<SavedContact> springs);

    /// Adds forces and couples of all contacts at a time, and the stiffness of their friction. `attached`: by slot
    /// of `bodies`, whose places are those of the state.
    void add(Exposure& bodies, std::span<const AttachedSlot> attached, std::span<const Slot<1>> state, double time,
             bool with_stiffness, StaticContactLoads& out);

    /// True where contacts that touch damp at this time.
    bool damps(double time) const;
    /// Adds the damping of all contacts at a time, in `turning`.
    void add_damping(Exposure& bodies, std::span<const AttachedSlot> attached, std::span<const Slot<1>> state,
                     double time, StaticContactLoads& out);

private:
    /// Rates of the step from `then`.
    void show_rates(Exposure& bodies, std::span<const Slot<1>> state, std::span<const Slot<1>> then) const;
    void take_loads(const Exposure& bodies, std::span<const AttachedSlot> attached, std::span<const Slot<1>> state,
                    const SlotLoads& loads, StaticContactLoads& out) const;
    /// Adds the stiffness of a contact's friction, or its damping.
    void add_slopes_of(Slopes by, const Exposure& bodies, std::span<const AttachedSlot> attached,
                       std::span<const Slot<1>> state, std::span<const Slot<1>> then,
                       std::span<const ContactNumbers<double>> numbers, const Contact& one, const SavedContact& left,
                       StaticContactLoads& out) const;
    /// The spring with which the step begins.
    FrictionSpring<double> spring_before(const Exposure& bodies, std::span<const AttachedSlot> attached,
                                         const Contact& contact, const SavedContact& left) const;

    ContactScene scene_; ///< with a margin on static friction
    std::span<const RodGroup> groups_;
    std::vector<LocalRod> rods_;
    const Threads& threads_;
    std::vector<Slot<1>> reference_;
    std::vector<SavedContact> springs_, left_; ///< in the reference state; after the last step. By pair
};

} // namespace skein
