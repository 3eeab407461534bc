// Surface of a rigid body in a fluid: signed distance, markers, and the fluid that it displaces.
#pragma once

#include "core/principal_axes.hpp"
#include "immersion/rod_surface.hpp"
#include "rod/body_shape.hpp"

#include <vector>

namespace skein {

/// Signed distance of a place from a part, m, above 0 outside; lengths as in BodyShape.
double distance_from(const BodyShape::Part& part, const Vec3d& place);

/// Volume that a body displaces, m^3, its centre, m, and its second moments, the inertia for a density of 1, m^5. All
/// are about the centre of mass and along the principal axes of the body. Parts that overlap count once.
struct DisplacedVolume {
    double volume = 0;
    Vec3d centre{0, 0, 0};
    SymmetricMatrix inertia;
};
DisplacedVolume displaced_volume(const BodyShape& body);

/// Markers about a cell apart and `retraction` [m] within the surface, none within another part. Parts thinner than a
/// cell have markers on their axis or in their middle plane.
std::vector<RodMarker> body_markers(const BodyShape& body, double spacing, double retraction);

} // namespace skein
