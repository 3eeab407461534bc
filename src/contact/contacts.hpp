// Contacts between rods: who may touch, who does, and what that does to them.                                theory.md section 18
//   evaluate: list of candidates, renewed when elements have moved half its skin; closest points and forces of eight pairs at a time;
//   each rod then gathers its own, in the order of the list
// No atomic, no order among threads: the bits depend on the rods alone. A contact's friction spring is kept by pair. Where a contact
// passes over a joint both elements touch, one at its end: that one follows the other's spring, and has it when it takes over.
#pragma once

#include "contact/broad_phase.hpp"
#include "contact/response.hpp"

#include <memory>
#include <optional>

namespace skein {

/// What contacts do to rods, by slot.
struct ContactLoads {
    std::vector<Vec3d> force;  ///< at nodes, lab, N
    std::vector<Vec3d> couple; ///< on elements, lab, N m
};

/// Of the last evaluation, but for the number of renewals.
struct ContactFigures {
    std::int64_t listed = 0, active = 0; ///< pairs
    double deepest = 0;                  ///< largest overlap over the smaller diameter
    std::int64_t renewals = 0;           ///< of the list, since the beginning
    double skin = 0;                     ///< m
};

/// A contact that is, for those who look.
struct Contact {
    Pair pair;
    double s, t;    ///< where on its elements
    Vec3d force;    ///< on the first, lab, N
    double overlap; ///< m
};

class Contacts {
public:
    Contacts(const Capsules& capsules, const ContactLaw& law, const Threads& threads);

    /// Loads of all contacts, over a step of length h, s.
    void evaluate(const Capsules& capsules, double h, ContactLoads& loads);

    ContactFigures figures() const { return figures_; }
    std::vector<Contact> active() const;

private:
    /// At one point of a pair.
    struct PointForce {
        Vec3d force, moment; ///< as in ContactForce
        double s, t, arm_a, arm_b;
    };
    /// The two ends between which near-parallel elements lie side by side.
    struct Ends {
        PointForce at[2];
    };
    /// What a task finds, and where.
    struct Block {
        std::vector<std::pair<std::uint32_t, Ends>> ends; ///< by pair
        std::int64_t active = 0;
        double deepest = 0;
    };

    bool list_is_used_up(const Capsules& capsules) const;
    void renew_list(const Capsules& capsules);
    void meet(const Capsules& capsules, double h, std::size_t begin, std::size_t end, Block& block);
    void meet_side_by_side(const Capsules& capsules, double h, std::uint32_t pair, double sine_squared, double first, double last, Block& block);
    void gather(const Capsules& capsules, std::size_t rod, ContactLoads& loads) const;
    /// x of a contact before this step. One at a joint has that of its neighbour beyond the joint, if that lies within its elements.
    Vec3d spring_before(const Capsules& capsules, std::size_t index, double s, double t) const;
    std::optional<std::size_t> find(std::uint32_t a, std::uint32_t b) const;

    ContactLaw law_;
    const Threads& threads_;
    BroadPhase search_;
    double diameter_; ///< mean of the elements', m
    Candidates candidates_;
    std::vector<Pair> pairs_;                          ///< the same, one by one
    std::vector<std::uint32_t> reverse_begin_, reverse_; ///< pairs in which an element is second
    std::vector<Vec3d> place_;                         ///< of nodes when the list was made
    std::vector<PointForce> force_;                    ///< by pair
    /// What a pair is doing, as bits.
    enum : std::uint8_t { touching = 1, side_by_side = 2, inside = 4 }; ///< inside: at no end of either element
    std::vector<std::uint8_t> active_, was_active_;
    std::vector<Vec3d> spring_, last_spring_;
    std::vector<double> overlap_;
    std::vector<Block> blocks_;
    std::int64_t age_ = 0; ///< steps since the list was made
    ContactFigures figures_;
};

} // namespace skein
