// What works contacts out, as the rest of a run sees it: loads of slots, figures, and what goes into checkpoints.
#pragma once

#include "contact/capsules.hpp"
#include "contact/contact_law.hpp"
#include "contact/response.hpp"
#include "parallel/threads.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace skein {

/// What contacts do to a slot.
struct alignas(64) ContactLoad {
    Vec3d force; ///< at the node, lab, N
    double unused = 0;
    Vec3d couple; ///< on the element, lab, N m
    double unused_too = 0;
};
static_assert(sizeof(ContactLoad) == 64 && sizeof(ContactMemory<double>) == 64);

/// Of the last evaluation, but for the number of renewals and what is lost; of pairs whose first rod is owned.
struct ContactFigures {
    std::int64_t listed = 0, active = 0; ///< pairs
    double deepest = 0;                  ///< largest overlap over the smaller diameter
    std::int64_t renewals = 0;           ///< of the list, since the beginning
    double skin = 0;                     ///< m
    double search_s = 0;                 ///< wall time of renewals since the beginning
    double stiffest = 0;                 ///< largest slope of the normal force over the overlap, N/m
    double stored = 0;                   ///< energy of normal and tangential springs, J
    double rubbed = 0, damped = 0;       ///< by friction and by dashpots since the beginning, J; what handing over of springs gives
                                         ///< counts against the former
};

/// A contact that is, for those who look.
struct Contact {
    Pair pair;
    double s, t;    ///< where on its elements
    Vec3d force;    ///< on the first, lab, N
    double overlap; ///< m
};

/// What a contact remembers from step to step.
struct KeptContact {
    std::uint32_t a, b;           ///< slots
    std::uint32_t what;           ///< bits, as Contacts means them
    ContactMemory<double> memory; ///< lab
};

/// One per rank; bits of the loads depend on the rods alone.
class ContactSolver {
public:
    virtual ~ContactSolver() = default;

    /// Goes on from what another left, before the first evaluation. May hold pairs of rods that are not owned.
    virtual void restore(std::span<const KeptContact> kept, double rubbed = 0, double damped = 0) = 0;
    /// Of pairs whose first rod is owned, in order.
    virtual std::vector<KeptContact> kept() const = 0;

    /// Loads of all contacts, over a step of length h, s. Those of rods that nothing touches mean nothing.
    virtual void evaluate(const Capsules& capsules, double time, double h, AlignedVector<ContactLoad>& loads) = 0;
    /// Not 0 for rods that are touched, of those owned.
    virtual std::span<const std::uint8_t> touched_rods() const = 0;

    virtual ContactFigures figures() const = 0;
    /// Of the last evaluation, which was of these capsules.
    virtual std::vector<Contact> active(const Capsules& capsules) const = 0;
};

/// Of the level of instructions that the caller is compiled for. `owned_rods`: those whose loads are wanted; none: all. Pairs
/// without any are left out.
std::unique_ptr<ContactSolver> make_contacts(const Capsules& capsules, ContactLaws laws, const Threads& threads,
                                             std::vector<std::uint8_t> owned_rods = {});

} // namespace skein
