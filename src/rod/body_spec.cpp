#include "skein/rod/body_spec.hpp"

namespace skein {

void SphereParts::fields(FieldVisitor& f) {
    f.visit({.name = "centres", .unit = "m", .text = "centre of each sphere; default for a single sphere: the origin"},
            centres);
    f.visit({.name = "radii", .unit = "m", .text = "radius of each sphere", .above = 0}, radii);
}

void CapsuleParts::fields(FieldVisitor& f) {
    f.visit({.name = "from", .unit = "m", .text = "centre of one round end of each capsule"}, from);
    f.visit({.name = "to", .unit = "m", .text = "centre of the other round end"}, to);
    f.visit({.name = "radii", .unit = "m", .text = "radius of each capsule", .above = 0}, radii);
}

void BoxParts::fields(FieldVisitor& f) {
    f.visit({.name = "centres", .unit = "m", .text = "centre of each box; default for a single box: the origin"},
            centres);
    f.visit({.name = "sizes",
             .unit = "m",
             .text = "sides of each box along the axes of the frame, including its rounded edges"},
            sizes);
    f.visit({.name = "radii",
             .unit = "m",
             .text = "radius of the edges of each box; contacts use it like the radius of a rod",
             .above = 0},
            radii);
}

void BodySpec::fields(FieldVisitor& f) {
    f.visit({.name = "mass", .unit = "kg", .text = "mass, instead of a density", .at_least = 0}, mass);
    f.visit_optional({.name = "centre", .unit = "m", .text = "centre of mass; default: centre of mass of the parts"},
                     centre);
    f.visit({.name = "inertia",
             .unit = "kg m^2",
             .text = "inertia about the centre of mass, along the axes of the parts: J_xx, J_yy, J_zz, or these and "
                     "J_xy, J_xz, J_yz (the elements of the matrix); default: inertia of the parts"},
            inertia);
    f.table({.name = "spheres"}, spheres);
    f.table({.name = "capsules"}, capsules);
    f.table({.name = "boxes"}, boxes);
}

} // namespace skein
