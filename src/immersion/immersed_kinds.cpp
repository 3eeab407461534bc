#include "immersion/immersed_kinds.hpp"

#include "rod/body_shape.hpp"

#include <algorithm>

namespace skein {

bool ImmersedKinds::sharp(const RodGroup& group) const {
    const BodyShape* const body = group.body();
    if (!body) {
        if (!numbers_.sharp_rods || group.heterogeneous()) return false;
        const bool plate = spans_box(group, grid_);
        for (std::size_t k = 0; k < group.element.size(); ++k) {
            const HalfAxes half = half_axes(group, k);
            if (std::min(half.along_d1, plate ? half.along_d1 : half.along_d2) < grid_.h) return false;
        }
        return true;
    }
    if (!numbers_.sharp_bodies) return false;
    return std::all_of(body->part.begin(), body->part.end(), [&](const BodyShape::Part& part) {
        return part.radius + std::min({part.half.x, part.half.y, part.half.z}) >= grid_.h;
    });
}

const ImmersedKinds::Kind& ImmersedKinds::of(const RodGroup& group, std::int64_t i) const {
    constexpr std::int64_t all = -1;
    const std::int64_t rod = group.heterogeneous() ? i : group.single_rod().value_or(all);
    const std::lock_guard lock(mutex_);
    std::unique_ptr<const Kind>& kept = kinds_[{group.id(), rod}];
    if (kept) return *kept;
    const RodGroup& own = group.kind(i);
    Kind kind{sharp(group) ? std::vector<RodMarker>() : rod_markers(own, grid_, numbers_.retraction), nullptr};
    if (numbers_.feels_fluid)
        kind.inertia = sharp(group) ? std::make_shared<const InertiaInFluid>(own, numbers_.density, numbers_.has_inner,
                                                                             !group.body() && spans_box(own, grid_))
                                    : std::make_shared<const InertiaInFluid>(own, kind.markers, numbers_.density,
                                                                             numbers_.has_inner);
    kept = std::make_unique<const Kind>(std::move(kind));
    return *kept;
}

} // namespace skein
