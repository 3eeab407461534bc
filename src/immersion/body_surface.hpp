// Surface of a rigid body in a fluid: signed distance, markers, and the fluid that it displaces.
#pragma once

#include "core/principal_axes.hpp"
#include "immersion/rod_surface.hpp"
#include "immersion/surface.hpp"
#include "rod/body_shape.hpp"

#include <utility>
#include <vector>

namespace skein {

/// Signed distance of a place from a part, m, above 0 outside; lengths as in BodyShape.
double distance_from(const BodyShape::Part& part, const Vec3d& place);

/// Surface of parts within a distance of the origin, m; of a body about its centre of mass and along its principal
/// axes.
class PartsSurface final : public Surface {
public:
    PartsSurface(std::vector<BodyShape::Part> parts, double reach) : parts_(std::move(parts)), reach_(reach) {}
    explicit PartsSurface(const BodyShape& body) : PartsSurface(body.part, body.reach) {}
    double distance(const Vec3d& place) const override;
    bool steady() const override { return true; }
    Vec3d extent() const override { return {reach_, reach_, reach_}; }

private:
    std::vector<BodyShape::Part> parts_;
    double reach_;
};

/// Volume that a body displaces, m^3, its centre, m, and its second moments, the inertia for a density of 1, m^5. All
/// are about the centre of mass and along the principal axes of the body. Parts that overlap count once.
struct DisplacedVolume {
    double volume = 0;
    Vec3d centre{0, 0, 0};
    SymmetricMatrix inertia;
};
DisplacedVolume displaced_volume(const BodyShape& body);

/// Inertia of the fluid around a body that accelerates, over that of the displaced fluid: by direction, and about the
/// axes over the sum of squares of what lies across, Lamb's for the ellipsoid of the same second moments.
struct AddedInertia {
    Vec3d linear, angular;
};
AddedInertia added_inertia(const DisplacedVolume& displaced);

/// Places of markers of one part, about a cell apart and `retraction` [m] within its surface.
std::vector<Vec3d> part_markers(const BodyShape::Part& part, double spacing, double retraction);

/// Markers about a cell apart and `retraction` [m] within the surface, none within another part. Parts thinner than a
/// cell have markers on their axis or in their middle plane.
std::vector<RodMarker> body_markers(const BodyShape& body, double spacing, double retraction);

} // namespace skein
