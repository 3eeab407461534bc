#include "immersion/immersed_rods.hpp"

#include <numeric>

namespace skein {

ImmersedRods::ImmersedRods(std::span<const RodGroup> groups, const Rods& rods, double spacing, double retraction)
    : groups_(groups), rods_(&rods) {
    std::int64_t first = 0;
    for (const RodGroup& group : groups_) {
        of_group_.push_back(rod_markers(group, spacing, retraction));
        first_.push_back(first);
        first += group.count() * static_cast<std::int64_t>(of_group_.back().size());
    }
    follow(rods);
}

void ImmersedRods::follow(const Rods& rods) {
    rods_ = &rods;
    all_.resize(rods.local().size());
    std::iota(all_.begin(), all_.end(), std::size_t{0});
    before_.assign(1, 0);
    for (const LocalRod& rod : rods.local())
        before_.push_back(before_.back() + of_group_[static_cast<std::size_t>(rod.group)].size());
}

void ImmersedRods::place(double lag, std::uint32_t first_body, std::int64_t first_identity, Markers& markers) const {
    const std::size_t others = markers.count();
    markers.resize(others + before_.back());
    rods_->read(all_, Copy::frames, lag, [&](int, std::size_t i, const RodCopy& rod) {
        const LocalRod& own = rods_->local()[i];
        const auto group = static_cast<std::size_t>(own.group);
        const std::vector<RodMarker>& on_rod = of_group_[group];
        const std::int64_t first = first_identity + first_[group] + own.index * static_cast<std::int64_t>(on_rod.size());
        for (std::size_t m = 0; m < on_rod.size(); ++m) {
            const RodMarker& marker = on_rod[m];
            const Slot<1>&from = rod.state[marker.element], &to = rod.state[marker.element + 1];
            const Mat3d& frame = rod.frames[marker.element];
            const Vec3d spin = lane(from.spin, 0), off = marker.off_d1 * frame.d1 + marker.off_d2 * frame.d2,
                        turning = transpose_times(frame, spin);
            const auto between = [&](const Vec3d& a, const Vec3d& b) { return (1 - marker.along) * a + marker.along * b; };
            const std::size_t at = others + before_[i] + m;
            markers.place[at] = between(lane(from.position, 0), lane(to.position, 0)) + off;
            markers.velocity[at] = between(lane(from.velocity, 0), lane(to.velocity, 0)) + cross(turning, off);
            markers.identity[at] = first + static_cast<std::int64_t>(m);
            markers.body[at] = first_body + static_cast<std::uint32_t>(group);
        }
    });
}

} // namespace skein
