// Interface of the contact solver to the rest of a run: loads of slots, figures, numbers of checkpoints.
#pragma once

#include "contact/broad_phase.hpp"
#include "contact/contact_law.hpp"
#include "contact/response.hpp"
#include "core/binned_sum.hpp"
#include "parallel/threads.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace skein {

struct ContactSpec;

/// A part of a body, if it is a box: half of its sides without the rounding, and that, m.
struct PartBox {
    Vec3d half{0, 0, 0};
    double radius = 0; ///< 0: it is none
};

/// Figures of contacts on this rank, over pairs whose first body is own: of the last evaluation, and where so said sums
/// since the beginning.
struct ContactFigures {
    std::int64_t candidates = 0, active = 0; ///< pairs; those that touch
    std::int64_t near = 0;      ///< those that touch or are nearer than the meeting zone, where there is one
    double weight = 0;          ///< sum over these of the pair's share in a contact of bodies: number of contacts
    double max_overlap = 0;     ///< largest overlap over the smaller diameter
    std::int64_t rebuilds = 0;  ///< rebuilds of the list of candidates, since the beginning
    double skin = 0;            ///< m
    double search_s = 0;        ///< wall time of rebuilds since the beginning
    double max_stiffness = 0;   ///< largest slope of the normal force over the overlap, N/m
    BinnedTotal elastic_energy; ///< energy of normal and tangential springs, J
    BinnedTotal friction_work;  ///< dissipated by friction since the beginning, J, less what springs gain when they are
                                ///< handed over
    BinnedTotal viscous_work;   ///< dissipated by viscous damping since the beginning, J

    explicit ContactFigures(const SumBins& energies)
        : elastic_energy(energies), friction_work(energies), viscous_work(energies) {}
};

/// A pair in contact at the last evaluation, for tables and messages.
struct Contact {
    Pair pair;
    double s, t;         ///< share of the contact along each element; 0 on a box
    Vec3d force;         ///< on the first, lab, N
    double overlap;      ///< m
    double diameter;     ///< the smaller one of both, m
    double weight;       ///< share of the pair in a contact of bodies, which neighbouring elements may have as well
    Vec3d place, normal; ///< midway in the overlap; from the first to the second; lab
    Vec3d slip;          ///< velocity of the first there against the second, m/s
};

/// Two elements that have changed sides within a step, or are about to. Their axes have crossed, or a ball's centre has
/// come within half the sum of radii, or boxes without their rounding intersect. theory.md (58c)
struct SideChange {
    Pair pair;       ///< the lower slot first
    double nearest;  ///< distance of their axes within the step, over the sum of radii; 0 where these crossed
    double speed;    ///< relative speed, m/s
    double energy;   ///< kinetic energy of that motion and energy of the contact before the step, J
    double diameter; ///< the smaller one of both, m; of boxes, of their edges
    friend bool operator==(const SideChange&, const SideChange&) = default;
};

/// Memory of a contact from step to step, wherever it is kept.
struct SavedContact {
    std::int64_t a, b;            ///< slots of the scene
    std::uint32_t status;         ///< bits of Contacts
    ContactMemory<double> memory; ///< lab
};

/// Masses, kg, and mobilities for springs of friction, 1/kg, of a group's rods that have sizes of their own.
struct OwnMasses {
    std::int64_t first_gid = 0;
    std::vector<double> mass, slip_mobility; ///< by rod; none of equal bodies
};

/// Laws, gaps and sizes of the whole scene, the same in the solvers of all ranks.
struct ContactScene {
    ContactLaws laws; ///< by pair of groups
    TouchRules rules;
    double diameter; ///< mean over elements, m
    std::int64_t slots;
    std::vector<std::vector<PartBox>> boxes; ///< by group and part; of groups without boxes none, without any no groups
    double thinnest = 0;                     ///< radius of the thinnest element, m
    std::vector<double> masses;              ///< mass of a body, by group, kg
    std::vector<double> slip_mobility;       ///< by group, 1/kg: contact_limits.hpp
    std::vector<OwnMasses> own;              ///< by group; no groups where the bodies of each are alike
    double largest_energy = 0; ///< energy of the stiffest normal spring between the widest elements one in another, J
    bool has_tangents = false; ///< loads come with their slopes: set_tangents()
    double meeting_zone = 0;   ///< gap of pairs that have slopes before they touch, m

    double mass_of(const Window& w) const { return of_body(masses, &OwnMasses::mass, w); }
    double slip_mobility_of(const Window& w) const { return of_body(slip_mobility, &OwnMasses::slip_mobility, w); }
    /// Numbers of a law for two bodies of the groups that it is for: a restitution holds for their own masses.
    ContactNumbers<double> for_bodies(ContactNumbers<double> numbers, const Window& a, const Window& b) const;

private:
    double of_body(const std::vector<double>& of_group, std::vector<double> OwnMasses::*of_rod, const Window& w) const {
        if (own.empty() || (nth(own, w.group).*of_rod).empty()) return nth(of_group, w.group);
        return nth(nth(own, w.group).*of_rod, w.gid - nth(own, w.group).first_gid);
    }
};
/// `joined`: rules of elements of one copy of an assembly; null: none of them touch.
ContactScene contact_scene(std::span<const RodGroup> groups, const ContactSpec& spec, ContactLaws laws,
                           std::shared_ptr<const JoinedGaps> joined = nullptr);

/// One per rank, of the bodies that it sees; bits of the loads on its own depend on the scene alone. A step: `holds`,
/// else a rebuild; then `begin`, and `finish` when ghosts have arrived. A rebuild: `prepare_rebuild`, `search` among
/// all that may be near, `finish_rebuild`.
class ContactSolver {
public:
    virtual ~ContactSolver() = default;

    /// True where there is a list and it pays to keep it; the same on all ranks.
    virtual bool worth_keeping() const = 0;
    /// True where the list is worth keeping and has all pairs that may touch where bodies are now.
    virtual bool holds(const Exposure& bodies) = 0;
    /// Distance between elements up to which pairs go into the next list, m: the same on all ranks.
    virtual double next_skin() = 0;
    /// Prepares for new numbers of slots. Forgets `begin` of a step that is to begin anew.
    virtual void prepare_rebuild(const Exposure& bodies) = 0;
    /// Pairs of all that may be near. Marks slots of ghosts that are in some pair. Returns the number of pairs whose
    /// first body is own and that do not touch.
    virtual std::int64_t search(const Exposure& near, std::span<std::uint8_t> wanted) = 0;
    /// Pairs of the last search, until they are settled.
    virtual const Candidates& found() const = 0;
    /// The list is that of the search; `slot`: by slot of `near`, where it is among `bodies` now. `inactive`: sum of
    /// search() over ranks.
    virtual void finish_rebuild(const Exposure& bodies, std::span<const std::uint32_t> slot, std::int64_t inactive) = 0;

    /// Memory and work that an earlier run left, before the first search. May hold pairs that are not of this rank.
    virtual void restore(std::span<const SavedContact> kept, const BinnedTotal& friction_work,
                         const BinnedTotal& viscous_work) = 0;
    /// Keeps the memory of contacts and their works in one of two places, and takes it back.
    virtual void keep(std::size_t place, const Exposure& bodies) = 0;
    virtual void go_back(std::size_t place, const Exposure& bodies) = 0;
    /// Units of the sums of energies and works, the same on all ranks.
    virtual const SumBins& energy_bins() const = 0;
    /// Memory of contacts whose first body is own, in order of pairs.
    virtual std::vector<SavedContact> saved(const Exposure& bodies) const = 0;

    /// Place of the slopes of the next step's contacts, by slot, where the scene has them.
    virtual void set_tangents(std::span<SlotTangent> tangents) = 0;
    /// Contacts of blocks of bodies that need no ghosts, over a step of length h, s. `may_repeat`: other ranks may
    /// still ask for a rebuild, after which the step begins anew.
    virtual void begin(const Exposure& bodies, double time, double h, std::span<ExertedLoad> loads,
                       bool may_repeat) = 0;
    /// Contacts of the other blocks; then loads are those of all contacts. Loads of bodies without contact mean
    /// nothing.
    virtual void finish(const Exposure& bodies, double h, std::span<ExertedLoad> loads) = 0;
    /// Flags by window: not 0 where the body is own and in contact.
    virtual std::span<const std::uint8_t> touched() const = 0;

    virtual ContactFigures figures() const = 0;
    /// Work of a step by window, in pairs that touch. A pair counts for the body of its first element.
    virtual std::vector<double> work(const Exposure& bodies) const = 0;
    /// Energies of the normal springs of pairs whose first body is own, J, in order of pairs. They follow from places
    /// alone. The bodies are those of the last evaluation, moved on by no more than a part of a step.
    virtual std::vector<double> normal_energies(const Exposure& bodies) const = 0;
    /// Contacts of the last evaluation, which was of these bodies, whose first body is own.
    virtual std::vector<Contact> active(const Exposure& bodies) const = 0;

    /// Time, s, for which bodies have moved at the rates that they show; set before holds(). 0: unknown, and no side
    /// changes are searched.
    virtual void arrived_in(double drift) = 0;
    /// The longest way of an own element in that time, m, and which of them have to be followed in the next search().
    virtual double largest_displacement(const Exposure& bodies) = 0;
    /// The longest way of any rank's: the next search() also finds what such elements may have passed.
    virtual void set_largest_displacement(double way) = 0;
    /// Pairs of the last step that changed sides, in order.
    virtual std::span<const SideChange> side_changes() const = 0;

    /// A step of bodies none of which is a ghost, with a rebuild where one is due.
    void evaluate(const Exposure& bodies, double time, double h, SlotLoads& loads);
};

/// A solver of the level of instructions that the caller is compiled for.
std::unique_ptr<ContactSolver> make_contacts(ContactScene scene, const Threads& threads);

} // namespace skein
