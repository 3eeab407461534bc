// What a fluid does to slots of rods from one meeting with it to the next: a load and a drag that stay as they are, and
// what rods receive of both. theory.md (88), (89)
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "tiles/rods.hpp"

#include <span>
#include <vector>

namespace skein {

/// Force `push - drag v` at the node, couple `couple - turn_drag w` on the element.
struct alignas(64) FluidLoad {
    Vec3d push{0, 0, 0}; ///< N, lab
    double unused = 0;
    Vec3d drag{0, 0, 0}; ///< kg/s, of lab components
    double unused_too = 0;
    Vec3d couple{0, 0, 0}; ///< N m, lab
    double unused_three = 0;
    Vec3d turn_drag{0, 0, 0}; ///< N m s, of body components
    double unused_four = 0;
};
/// Received since the last meeting, lab.
struct alignas(64) FluidImpulse {
    Vec3d on_node{0, 0, 0}; ///< N s
    double unused = 0;
    Vec3d on_element{0, 0, 0}; ///< N m s
    double unused_too = 0;
};

/// Of all slots of this rank's rods, written by meetings with the fluid and by one pass.
class FluidLoads {
public:
    AlignedVector<FluidLoad> load;
    AlignedVector<FluidImpulse> received;

    FluidLoads(std::span<const RodGroup> groups, std::span<const LocalRod> rods) : first_of_group_(groups.size(), 0) {
        for (std::size_t i = rods.size(); i-- > 0;) nth(first_of_group_, rods[i].group) = i;
        first_.assign(1, 0);
        for (const LocalRod& rod : rods)
            first_.push_back(first_.back() + static_cast<std::size_t>(nth(groups, rod.group).slots()));
        load.resize(first_.back());
        received.resize(first_.back());
    }
    /// First slot of local()[i].
    std::size_t first(std::size_t i) const { return first_[i]; }
    /// The same of a rod by its place among those of its group on this rank.
    std::size_t first(int group, std::size_t place) const { return first_[nth(first_of_group_, group) + place]; }

    static constexpr double bytes_per_slot = sizeof(FluidLoad) + sizeof(FluidImpulse);

private:
    std::vector<std::size_t> first_, first_of_group_; ///< local()[first_of_group_[g]] is the first of group g
};

} // namespace skein
