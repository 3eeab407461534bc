#include "immersion/immersed_kinds.hpp"

#include "rod/body_shape.hpp"

#include <algorithm>

namespace skein {

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
    // Markers end at the retraction. If an end is thin beyond it alone, they would leave their share to nobody.
    if (kind.markers.empty()) std::fill(kind.sharp_shares.begin(), kind.sharp_shares.end(), 1.0);
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
