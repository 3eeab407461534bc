#include "immersion/immersed_rods.hpp"

#include "skein/core/index.hpp"

#include <numeric>

namespace skein {

ImmersedRods::ImmersedRods(std::span<const RodGroup> groups, const Rods& rods, const FluidGrid& grid, double retraction)
    : groups_(groups), rods_(&rods) {
    std::int64_t first = 0;
    for (const RodGroup& group : groups_) {
        of_group_.push_back(rod_markers(group, grid, retraction));
        first_.push_back(first);
        first += group.count() * static_cast<std::int64_t>(of_group_.back().size());
    }
    rebind(rods);
}

void ImmersedRods::rebind(const Rods& rods) {
    rods_ = &rods;
    all_.resize(rods.local().size());
    std::iota(all_.begin(), all_.end(), std::size_t{0});
    before_.assign(1, 0);
    for (const LocalRod& rod : rods.local()) before_.push_back(before_.back() + nth(of_group_, rod.group).size());
}

void ImmersedRods::place(double lag, std::uint32_t first_body, std::int64_t first_identity, Markers& markers) const {
    const std::size_t others = markers.count();
    markers.resize(others + before_.back());
    read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        const LocalRod& own = rods_->local()[i];
        const std::size_t group = to_index(own.group);
        const std::int64_t first =
            first_identity + first_[group] + own.index * static_cast<std::int64_t>(of_group_[group].size());
        for_markers(i, [&](std::size_t m, const RodMarker& marker) {
            const Slot<1>&from = rod.state[marker.element], &to = rod.state[second_slot(marker, rod.state.size())];
            const Mat3d& frame = rod.frames[marker.element];
            const Vec3d turning = transpose_times(frame, lane(from.spin, 0));
            const std::size_t at = others + m;
            markers.place[at] = place_of(marker, rod);
            markers.velocity[at] =
                along(marker, lane(from.velocity, 0), lane(to.velocity, 0)) + cross(turning, off_axis(marker, frame));
            markers.identity[at] = first + static_cast<std::int64_t>(m - before_[i]);
            markers.body[at] = first_body + static_cast<std::uint32_t>(group);
        });
    });
}

} // namespace skein
