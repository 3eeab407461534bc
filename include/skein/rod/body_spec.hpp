// Keys of a rigid body besides its name, motion and places: solid parts of one density, in a frame of their own, or its
// mass and inertia.
#pragma once

#include "skein/core/fields.hpp"

#include <optional>
#include <vector>

namespace skein {

struct SphereParts {
    std::vector<Vec3d> centres; ///< m; may be left out for a single sphere: the origin
    std::vector<double> radii;  ///< m

    void fields(FieldVisitor& f);
};

/// Cylinders with half balls at both ends.
struct CapsuleParts {
    std::vector<Vec3d> from, to; ///< centres of the round ends, m
    std::vector<double> radii;   ///< m

    void fields(FieldVisitor& f);
};

/// Boxes along the axes of the frame, with rounded edges: all points within `radius` of a box that is smaller by
/// `radius`.
struct BoxParts {
    std::vector<Vec3d> centres, sizes; ///< m; sizes include the rounding
    std::vector<double> radii;         ///< radii of the edges, m

    void fields(FieldVisitor& f);
};

struct BodySpec {
    double mass = 0;             ///< kg; 0: from the density
    std::optional<Vec3d> centre; ///< centre of mass, m; that of the parts where absent
    /// Inertia about the centre, along the axes of the parts, kg m^2: empty, or J_xx, J_yy, J_zz, or these and J_xy,
    /// J_xz, J_yz.
    std::vector<double> inertia;
    SphereParts spheres;
    CapsuleParts capsules;
    BoxParts boxes;

    /// Keys of a [[bodies]] after its density.
    void fields(FieldVisitor& f);
};

} // namespace skein
