// What contact sees of rods: elements as capsules, one after another along their rods.
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/vec3.hpp"

#include <compare>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace skein {

/// One per slot: where things are, which is all that a search and the test of a candidate need. Element k of a rod lies between its
/// slots k and k + 1; the last slot of a rod has no element.
struct CapsuleNode {
    Vec3d position; ///< lab, m
    double radius;  ///< of the element, m; below 0 where the slot has none
};
static_assert(sizeof(CapsuleNode) == 32);
/// One per slot: how things move, which only contacts ask for.
struct CapsuleMotion {
    Vec3d velocity; ///< of the node, lab, m/s
    double unused = 0;
    Vec3d spin; ///< of the element, lab, rad/s
    double unused_too = 0;
};
static_assert(sizeof(CapsuleMotion) == 64);
/// All of a slot, as ranks send it to each other: copied as it is, never number by number.
struct CapsuleSlot {
    CapsuleNode node;
    CapsuleMotion motion;
};
static_assert(std::is_trivially_copyable_v<CapsuleSlot> && sizeof(CapsuleSlot) == 96);

/// Two elements.
struct Pair {
    std::uint32_t a, b; ///< slots
    friend auto operator<=>(const Pair&, const Pair&) = default;
};

/// Rods of a scene as they touch.
struct Capsules {
    AlignedVector<CapsuleNode> node;
    AlignedVector<CapsuleMotion> motion;
    std::vector<std::int32_t> rod;        ///< of each slot
    std::vector<std::int32_t> first_slot; ///< of each rod, and behind the last
    std::vector<std::int32_t> skip;       ///< per rod: its elements touch where their numbers differ by more; below 0: never
    std::vector<std::int32_t> material;   ///< per rod; none where one law holds for all

    std::size_t slots() const { return node.size(); }
    bool has_element(std::size_t slot) const { return node[slot].radius >= 0; }
    /// Elements that may touch, by what they are and not where.
    bool may_touch(std::size_t a, std::size_t b) const {
        if (rod[a] != rod[b]) return true;
        const std::int32_t gap = skip[static_cast<std::size_t>(rod[a])],
                           apart = static_cast<std::int32_t>(a) - static_cast<std::int32_t>(b);
        return gap >= 0 && (apart > gap || -apart > gap);
    }
};

} // namespace skein
