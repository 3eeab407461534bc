#include "immersion/immersed_rods.hpp"

#include "skein/core/index.hpp"

#include <numeric>
#include <utility>

namespace skein {

ImmersedRods::ImmersedRods(std::span<const RodGroup> groups, const Rods& rods,
                           std::shared_ptr<const ImmersedKinds> kinds)
    : groups_(groups), rods_(&rods), kinds_(std::move(kinds)) {
    std::int64_t first = 0;
    const auto markers = [&](const RodGroup& group, std::int64_t i) {
        return static_cast<std::int64_t>(kinds_->of(group, i).markers.size());
    };
    for (const RodGroup& group : groups_) {
        OfGroup& of = groups_in_scene_.emplace_back(OfGroup{first, {}, 0});
        const bool sharp = kinds_->sharp(group);
        first_sharp_.push_back(sharp ? static_cast<std::int64_t>(groups_of_sharp_.size()) : -1);
        if (sharp) groups_of_sharp_.resize(groups_of_sharp_.size() + to_index(group.count()), first_sharp_.size() - 1);
        has_markers_ |= !sharp;
        has_sharp_rods_ |= sharp && !group.body();
        if (!group.heterogeneous()) {
            of.of_each = markers(group, 0);
            first += group.count() * of.of_each;
            continue;
        }
        for (std::int64_t i = 0; i < group.count(); ++i) {
            of.before.push_back(first - of.first);
            first += markers(group, i);
        }
    }
    rebind(rods);
}

void ImmersedRods::rebind(const Rods& rods) {
    rods_ = &rods;
    all_.resize(rods.local().size());
    std::iota(all_.begin(), all_.end(), std::size_t{0});
    before_.assign(1, 0);
    constants_.clear();
    kind_.clear();
    for (const LocalRod& rod : rods.local()) {
        const RodGroup& group = nth(groups_, rod.group);
        constants_.push_back(&group.kind(rod.index));
        kind_.push_back(&kinds_->of(group, rod.index));
        before_.push_back(before_.back() + kind_.back()->markers.size());
    }
}

std::int64_t ImmersedRods::sharp_number(std::size_t i) const {
    const LocalRod& own = rods_->local()[i];
    const std::int64_t first = nth(first_sharp_, own.group);
    return first < 0 ? -1 : first + own.index;
}

void ImmersedRods::place(double lag, std::uint32_t first_body, std::int64_t first_identity, Markers& markers) const {
    const std::size_t others = markers.count();
    markers.resize(others + before_.back());
    read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        const LocalRod& own = rods_->local()[i];
        const std::int64_t first = first_identity + nth(groups_in_scene_, own.group).of_rod(own.index);
        for_markers(i, [&](std::size_t m, const RodMarker& marker) {
            const Slot<1>&from = rod.state[marker.element], &to = rod.state[second_slot(marker, rod.state.size())];
            const Mat3d& frame = rod.frames[marker.element];
            const Vec3d turning = transpose_times(frame, lane(from.spin, 0));
            const std::size_t at = others + m;
            markers.place[at] = place_of(marker, rod);
            markers.velocity[at] =
                along(marker, lane(from.velocity, 0), lane(to.velocity, 0)) + cross(turning, off_axis(marker, frame));
            markers.identity[at] = first + static_cast<std::int64_t>(m - before_[i]);
            markers.body[at] = first_body + static_cast<std::uint32_t>(own.group);
        });
    });
}

} // namespace skein
