// Loads of the fluid on slots of rods during a stage, constant until its end, and the impulses that rods receive from
// them. theory.md (88), (89)
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "tiles/rods.hpp"

#include <span>
#include <vector>

namespace skein {

/// Force `push - drag v` on the node and couple `couple - turn_drag w` on the element.
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
/// Impulses since the begin of the stage, lab.
struct alignas(64) FluidImpulse {
    Vec3d on_node{0, 0, 0}; ///< N s
    double unused = 0;
    Vec3d on_element{0, 0, 0}; ///< N m s
    double unused_too = 0;
};

/// Loads and impulses of all slots of this rank's rods. ForceBalance writes loads, FluidLoadPass impulses.
class FluidLoads {
public:
    AlignedVector<FluidLoad> load;
    AlignedVector<FluidImpulse> received;

    FluidLoads(std::span<const RodGroup> groups, std::span<const LocalRod> rods) : first_of_group_(groups.size(), 0) {
        for (std::size_t i = rods.size(); i-- > 0;) nth(first_of_group_, rods[i].group) = i;
        first_.assign(1, 0);
        for (const LocalRod& rod : rods) first_.push_back(first_.back() + to_index(nth(groups, rod.group).slots()));
        load.resize(first_.back());
        received.resize(first_.back());
    }
    /// First slot of local()[i].
    std::size_t first(std::size_t i) const { return first_[i]; }
    /// First slot of a rod, by its place among the rods of its group on this rank.
    std::size_t first(int group, std::size_t place) const { return first_[nth(first_of_group_, group) + place]; }

    static constexpr double bytes_per_slot = sizeof(FluidLoad) + sizeof(FluidImpulse);

private:
    std::vector<std::size_t> first_, first_of_group_; ///< local()[first_of_group_[g]] is the first of group g
};

} // namespace skein
