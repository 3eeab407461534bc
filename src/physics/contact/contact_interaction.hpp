// Contacts between rods as an interaction: their loads, figures, tables and memory.
#pragma once

#include "contact/contact_limits.hpp"
#include "contact/contact_solver.hpp"
#include "coupling/interaction.hpp"
#include "partition/partition.hpp"
#include "physics/contact/contact_plan.hpp"

#include <optional>

namespace skein {

class ContactInteraction final : public Interaction {
public:
    /// `contact`: of the plan, which outlives it.
    ContactInteraction(const InteractionParts& parts, const ContactPlan& contact);

    bool couples() const override { return true; }
    bool holds() override { return contacts_->holds(*exposure_); }
    double begin_rebuild() override;
    void find_partners(const Exposure& near, std::span<std::uint8_t> wanted) override;
    void settle(std::span<const std::uint32_t> slot) override;
    void rebind(const InteractionParts& parts) override;
    void add_work(std::span<const LocalRod> own, std::span<double> work) const override;
    void begin(const Step& first, Timers& timers) override;
    void begin_evaluation() override;
    void add_own(const Step& step) override;
    void add_shared(const Step& step) override;
    void keep(std::size_t place) override;
    void go_back(std::size_t place) override;
    std::string invalid() const override;
    std::string cause() const override { return cause_; }
    std::vector<std::string> remedies() const override { return remedies_; }
    double step_limit() const override;
    double longest_part() const override;
    std::string tightest_pair() const override;
    Touch strongest_touch(std::int64_t gid) const override;
    std::span<OverlapWatch> overlaps() override { return {&overlap_, 1}; }
    std::vector<Figure> figures(const Sample&) const override;
    std::string saved_name() const override { return "contact_memory"; }
    /// Energies of all contacts; rows: the memory of each, by pair, on the rank whose block of gids has its first rod.
    SavedNumbers saved() const override;
    void restore(const SavedNumbers& kept) override;
    /// Memory of the contacts whose first body is of this rank, in order of pairs.
    std::vector<SavedContact> memory() const { return before_ ? before_->memory : contacts_->saved(*exposure_); }
    /// Goes on from these, of bodies of this rank alone, with the works of before.
    void set_memory(std::span<const SavedContact> contacts);

    /// Every contact of the scene, a line each, in order of pairs: the part of ranks one after another, with the head
    /// on root. Collective.
    std::string table() const;
    /// Forces of the last step's contacts on the exposed slots of a rod of this rank, lab, N: zeros before the first
    /// step, and not numbers before the first one after a checkpoint, which does not keep them.
    void forces(std::int64_t gid, std::span<Vec3d> out) const;

    /// An energy audit begins, in which positions are by `lag` behind the rates, s.
    void begin_audit(double lag);
    /// Energy that contacts store, by how far bodies overlap, and what friction and dashpots have dissipated, J: now,
    /// and when an audit began here. Collective.
    double booked(double lag) const;
    double booked_at_start() const;
    /// True until the first step of an audit has been made.
    bool audit_begins() const { return audit_begins_.has_value(); }

private:
    /// Energies and works of contacts that an audit counts, on this rank.
    struct Bookings {
        std::vector<double> energies;
        std::vector<BinnedTotal> totals;
        void add(const Bookings& other);
    };
    /// Memory and works before an evaluation for figures.
    struct Before {
        SavedNumbers numbers;
        std::vector<SavedContact> memory;
        BinnedTotal friction_work, viscous_work;
    };
    /// Figures with the works of before.
    ContactFigures present_figures() const;
    double sum(const Bookings& mine) const;
    /// Energies of this rank with bodies where they will be in this time at their last rates, s; 0 before the first
    /// step.
    Bookings bookings(double after) const;
    OwnerDirectory directory() const;
    /// Element of a rod, or part of a body, at a slot.
    std::int64_t element(std::size_t slot) const;
    /// Body and element of a slot, in words.
    std::string place_of(std::size_t slot) const;
    void take_side_change(const SideChange& change, const Step& step);
    void watch_overlap(const Step& step);
    double stiffening() const;

    const Communicator comm_;
    const Plan& plan_;
    const ContactPlan& contact_;
    std::span<const RodGroup> groups_;
    std::shared_ptr<const Exposure> exposure_;
    std::shared_ptr<SlotLoads> loads_;
    std::int64_t all_rods_;
    std::unique_ptr<ContactSolver> contacts_;
    /// Contacts of a group under one of its laws, with itself or another group, which may leave a shorter step.
    struct Guard {
        std::size_t group;
        ContactLaw law;       ///< of two bodies alike
        double own_limit = 0; ///< s, at an overlap of a diameter, if stiffnesses of others do not count; else 0
    };
    void add_guards(std::size_t group, std::span<const ContactLaw> laws);

    std::vector<ContactMobility> mobility_; ///< by group
    std::vector<Guard> guards_;
    double planned_limit_ = HUGE_VAL; ///< of explicit steps by contacts with the overlap that is allowed, s
    double soft_until_ = 0;           ///< s; the last of the laws
    OverlapWatch overlap_;
    std::array<OverlapWatch, 2> kept_overlap_;
    double behind_ = 0;                 ///< s, by which bodies have been shown before the end of their step
    std::string side_change_, cause_;   ///< the first of this rank, in words; empty: none
    std::vector<std::string> remedies_; ///< of that
    double step_of_change_ = HUGE_VAL; ///< s, in which that pair would move no farther than the overlap that is allowed
    bool follows_ = false;             ///< bodies of a running step have come here
    std::int64_t inactive_ = 0;        ///< pairs of the last search that do not touch, whose first body is own
    bool forces_lost_ = false;         ///< since a checkpoint was loaded
    std::optional<Before> before_;     ///< since an evaluation for figures
    std::optional<double> audit_begins_; ///< lag of an audit whose first step is not yet done, s
    Bookings start_bookings_;            ///< none where no audit began here
};

/// Contacts among them; null where rods do not feel each other.
ContactInteraction* contacts_of(const Interactions& all);

} // namespace skein
