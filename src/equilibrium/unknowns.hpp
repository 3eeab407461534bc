// Free unknowns of bodies at rest: what ends, holds and common nodes leave of six per slot. theory.md (96)
#pragma once

#include "kernels/static_rods.hpp"
#include "skein/rod/rod_group.hpp"
#include "tiles/rods.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// An unknown of a slot as a sum of free ones.
struct UnknownPart {
    int unknown;
    double factor;
};
using SlotParts = std::array<std::vector<UnknownPart>, slot_unknowns>;

class Unknowns {
public:
    Unknowns(std::span<const RodGroup> groups, std::span<const LocalRod> rods, const StaticRods& at_rest);

    int count() const { return count_; }
    std::size_t slots() const { return number_.size(); }
    /// Parts of the unknowns of a slot in this state; each unknown has one part of factor 1, or none, unless it is
    /// turned or led by a body.
    SlotParts parts(std::size_t slot, std::span<const Slot<1>> state) const;
    /// True where parts() is the same in all states.
    bool plain(std::size_t slot) const { return turned_[slot] == 0 && on_body_[slot] < 0; }
    /// Number of the free unknown of a plain slot's; -1 where it is held.
    int of(std::size_t slot, std::size_t i) const { return number_[slot][i]; }
    const std::array<int, slot_unknowns>& of(std::size_t slot) const { return number_[slot]; }
    /// Slots whose element is held about one lab axis and free about both others.
    const std::vector<std::size_t>& held_about_one() const { return held_about_one_; }

    /// Adds a correction to a state, in all slots. `turn`: of elements, body, rad; both as they were applied.
    struct Moves {
        std::vector<Vec3d> node, turn;
    };
    Moves moves(std::span<const double> correction, std::span<const Slot<1>> state) const;
    void apply(const Moves& moves, double share, std::span<Slot<1>> state) const;
    /// Copies what is held: components of nodes, and elements that do not turn at all.
    void put_held(std::span<const Slot<1>> from, std::span<Slot<1>> to) const;
    /// Puts nodes at the places of those that they move with.
    void gather(std::span<Slot<1>> state) const;

    /// Node or element, and rod, of an unknown, in words.
    struct Place {
        std::size_t rod;
        int slot, i;
    };
    Place place(int unknown) const { return place_[static_cast<std::size_t>(unknown)]; }
    const std::vector<std::size_t>& rod_of_slot() const { return rod_of_slot_; }

private:
    void number_rod(const RodGroup& group, std::size_t rod, std::size_t first);

    std::vector<std::array<int, slot_unknowns>> number_;
    std::vector<unsigned char> turned_; ///< the turn's unknowns are about lab axes
    std::vector<std::size_t> held_about_one_;
    std::vector<long> on_body_; ///< place in bodies_ of the node's body; -1: none
    std::vector<CommonNode> shared_;
    std::vector<Place> place_;
    std::vector<std::size_t> rod_of_slot_;
    int count_ = 0;
};

} // namespace skein
