#include "immersion/immersed_kinds.hpp"

#include "rod/body_shape.hpp"

#include <algorithm>

namespace skein {

namespace {

/// Markers end at the retraction. A thin part that is shorter has none, so that its share would move nobody and come to
/// a part elsewhere: it acts by its surface. `shares`: of nodes, of which the first and the last of a ring are one.
void give_parts_without_markers(const std::vector<RodMarker>& markers, bool ring, std::vector<double>& shares) {
    const std::size_t elements = shares.size() - 1;
    std::vector<bool> has_marker(elements);
    for (const RodMarker& m : markers) has_marker[m.element] = true;
    const auto has_thin_end = [&](std::size_t k) { return shares[k] < 1 || shares[k + 1] < 1; };
    struct Part {
        std::size_t begin, end; ///< elements
        bool marked;
    };
    std::vector<Part> parts;
    for (std::size_t k = 0; k < elements; ++k) {
        if (!has_thin_end(k)) continue;
        if (parts.empty() || parts.back().end < k || shares[k] == 1) parts.push_back({k, k, false});
        parts.back().end = k + 1;
        parts.back().marked = parts.back().marked || has_marker[k];
    }
    if (ring && shares.front() < 1)
        parts.front().marked = parts.back().marked = parts.front().marked || parts.back().marked;
    for (const Part& part : parts)
        if (!part.marked)
            std::fill_n(shares.begin() + static_cast<std::ptrdiff_t>(part.begin), part.end - part.begin + 1, 1.0);
}

} // namespace

bool ImmersedKinds::sharp_body(const BodyShape& body) const {
    return numbers_.sharp_bodies && std::all_of(body.part.begin(), body.part.end(), [&](const BodyShape::Part& part) {
               return part.radius + std::min({part.half.x, part.half.y, part.half.z}) >= grid_.h;
           });
}

ImmersedKinds::Kind ImmersedKinds::kind_of(const RodGroup& own) const {
    Kind kind;
    if (const BodyShape* const body = own.body()) kind.sharp = sharp_body(*body);
    else if (numbers_.sharp_rods) {
        kind.sharp_shares = sharp_shares(own, grid_);
        kind.sharp = !kind.sharp_shares.empty();
    }
    if (!kind.sharp || !own.body()) kind.markers = rod_markers(own, grid_, numbers_.retraction, kind.sharp_shares);
    if (!kind.sharp_shares.empty()) give_parts_without_markers(kind.markers, own.closed(), kind.sharp_shares);
    if (!numbers_.feels_fluid) return kind;
    if (kind.sharp && own.body())
        kind.inertia = std::make_shared<const InertiaInFluid>(*own.body(), numbers_.density, numbers_.has_inner);
    else
        kind.inertia = std::make_shared<const InertiaInFluid>(own, kind.markers, numbers_.density, numbers_.has_inner,
                                                              kind.sharp_shares, spans_box(own, grid_));
    return kind;
}

const ImmersedKinds::Kind& ImmersedKinds::of(const RodGroup& group, std::int64_t i) const {
    constexpr std::int64_t all = -1;
    const std::int64_t rod = group.heterogeneous() ? i : group.single_rod().value_or(all);
    const std::lock_guard lock(mutex_);
    std::unique_ptr<const Kind>& kept = kinds_[{group.id(), rod}];
    if (kept) return *kept;
    kept = std::make_unique<const Kind>(kind_of(group.kind(i)));
    return *kept;
}

} // namespace skein
