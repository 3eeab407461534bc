// Contacts at rest: energy, forces and stiffness of their normal springs, from places alone, and of their
// friction from a state on in which its springs are known. Dashpots do nothing at rest.   theory.md section 18
#pragma once

#include "contact/contact_solver.hpp"
#include "skein/rod/slot.hpp"
#include "tiles/rods.hpp"
#include "tiles/slot_coupling.hpp"

#include <memory>
#include <span>
#include <vector>

namespace skein {

/// Two elements that touch.
struct StaticContact {
    std::size_t slot[2]; ///< of the elements, the lower one of the scene first
    double share[2];     ///< places of their nearest points
    double overlap;      ///< m
    double diameter;     ///< the smaller one of both, m
    Vec3d force;         ///< on the first element and its neighbours, lab, N
};

/// Sums over all contacts by slot of all rods, one after another.
struct StaticContactLoads {
    SlotShare share;            ///< set by who asks; sums beyond it are not complete
    double energy = 0;          ///< J
    double largest_overlap = 0; ///< over the smaller diameter
    std::vector<StaticContact> contacts;
    std::vector<Vec3d> force;            ///< at nodes, lab, N
    std::vector<Vec3d> couple;           ///< on elements and bodies, body, N m
    std::vector<double> force_size;      ///< sum of the sizes of the forces there, N
    std::vector<double> couple_size;     ///< the same of couples, N m
    std::vector<SlotCoupling> couplings; ///< stiffness by displacements of nodes; empty where none is asked for
    std::vector<SlotCoupling> turning;   ///< stiffness of friction, and of contacts with rigid bodies
};

class StaticContacts {
public:
    virtual ~StaticContacts() = default;
    /// Sets the time at which laws are taken, s; at first 0.
    virtual void set_time(double time) = 0;
    /// `state`: slots of all rods, one after another.
    virtual void evaluate(std::span<const Slot<1>> state, bool with_stiffness, StaticContactLoads& out) = 0;
    /// Leaves out of the stiffness of pairs without a box what makes it negative, or not: turns of normals and arms.
    virtual void make_convex(bool convex) = 0;
    /// Share of the way from `state` to `moved` on which no pair comes nearer than it may: half of the smaller radius
    /// further into each other than where they touch, or where they are; and no nearer than half of that distance.
    virtual double clear_share(std::span<const Slot<1>> state, std::span<const Slot<1>> moved) = 0;
    /// Damping at rest by dashpots, and by friction that vanishes with the speed of slip: minus the derivative of loads
    /// by rates, in `turning`.
    virtual void evaluate_damping(std::span<const Slot<1>> state, StaticContactLoads& out) = 0;
    /// True where friction acts.
    virtual bool rubs() const = 0;
    /// Friction acts from here on, where it has memory: its springs are those of this state.
    virtual void set_reference(std::span<const Slot<1>> state) = 0;
    /// Leaves friction out for a while, or not.
    virtual void take_friction(bool acts) = 0;
    /// The springs become those that the last evaluation left; its state is to be the next reference.
    virtual void keep_springs() = 0;
    virtual const std::vector<SavedContact>& springs() const = 0;
    virtual void set_springs(std::vector<SavedContact> springs) = 0;
};

/// Contacts of these rods and bodies by the laws and rules of their scene; `threads` must outlive them. Kernels are
/// those of the level of instructions that the caller is compiled for.
std::unique_ptr<StaticContacts> make_static_contacts(ContactScene scene, std::span<const RodGroup> groups,
                                                     std::span<const LocalRod> rods, const Threads& threads);

} // namespace skein
