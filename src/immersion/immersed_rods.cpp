#include "immersion/immersed_rods.hpp"

#include "skein/core/index.hpp"

#include <map>
#include <numeric>
#include <utility>

namespace skein {

ImmersedRods::ImmersedRods(std::span<const RodGroup> groups, const Rods& rods,
                           std::shared_ptr<const ImmersedKinds> kinds, std::vector<RodNumber> single)
    : groups_(groups), rods_(&rods), kinds_(std::move(kinds)), single_(std::move(single)) {
    std::int64_t first = 0;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        const RodGroup& group = groups_[g];
        OfGroup& of = groups_in_scene_.emplace_back(OfGroup{first, {}, 0});
        const ImmersedKinds::Kind* kind = nullptr;
        for (std::int64_t i = 0; i < group.count(); ++i) {
            if (!kind || group.heterogeneous()) kind = &kinds_->of(group, i);
            if (kind->sharp) sharp_.push_back({g, i});
            has_markers_ |= !kind->markers.empty();
            has_sharp_rods_ |= kind->sharp && !group.body();
            has_shares_ |= kind->sharp && !kind->markers.empty();
            of.of_each = static_cast<std::int64_t>(kind->markers.size());
            if (group.heterogeneous()) of.before.push_back(first - of.first);
            first += of.of_each;
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
    sharp_number_.clear();
    for (const LocalRod& rod : rods.local()) {
        const RodGroup& group = nth(groups_, rod.group);
        constants_.push_back(&group.kind(rod.index));
        kind_.push_back(&kinds_->of(group, rod.index));
        before_.push_back(before_.back() + kind_.back()->markers.size());
        sharp_number_.push_back(sharp_number(RodNumber{to_index(rod.group), rod.index}));
    }
    number_single();
}

std::int64_t ImmersedRods::sharp_number(const RodNumber& rod) const {
    const auto found = std::lower_bound(sharp_.begin(), sharp_.end(), rod);
    return found != sharp_.end() && *found == rod ? found - sharp_.begin() : -1;
}

void ImmersedRods::number_single() {
    single_number_.clear();
    if (single_.empty()) return;
    std::map<RodNumber, std::uint32_t> number;
    for (std::size_t s = 0; s < single_.size(); ++s) number.emplace(single_[s], static_cast<std::uint32_t>(s));
    for (const LocalRod& rod : rods_->local()) {
        const auto found = number.find(RodNumber{to_index(rod.group), rod.index});
        single_number_.push_back(found == number.end() ? Markers::no_part : found->second);
    }
}

SweptSurface ImmersedRods::swept_surface_of(std::size_t sharp, const FluidGrid& grid) const {
    const auto [group, index] = sharp_[sharp];
    return swept_surface(constants_of_sharp(sharp), grid, kinds_->of(groups_[group], index).sharp_shares);
}

void ImmersedRods::place_arms(std::size_t i, const RodCopy& rod, std::size_t first, double ahead,
                              std::uint32_t first_part, Markers& markers) const {
    if (single_number_[i] == Markers::no_part) return;
    const Vec3d origin = lane(rod.state[0].position, 0), velocity = lane(rod.state[0].velocity, 0);
    for (std::size_t at = first; at < first + kind_[i]->markers.size(); ++at) {
        markers.part[at] = first_part + single_number_[i];
        markers.arm[at] = markers.place[at] - origin + ahead * (markers.velocity[at] - velocity);
    }
}

void ImmersedRods::place(double lag, double ahead, std::uint32_t first_body, std::int64_t first_identity,
                         Markers& markers) const {
    const std::size_t others = markers.count();
    markers.resize(others + before_.back());
    if (has_shares_) markers.share.resize(markers.count(), 1);
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
            if (has_shares_) markers.share[at] = marker.share;
        });
        if (markers.has_parts && !single_.empty()) place_arms(i, rod, others + before_[i], ahead, first_body, markers);
    });
}

} // namespace skein
