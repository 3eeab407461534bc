#include "skein/rod/body_spec.hpp"

namespace skein {

void SphereParts::fields(FieldVisitor& f) {
    f.visit({.name = "centres", .unit = "m", .text = "of each sphere; of a single one the origin where absent"},
            centres);
    f.visit({.name = "radii", .unit = "m", .text = "of each sphere", .above = 0}, radii);
}

void CapsuleParts::fields(FieldVisitor& f) {
    f.visit({.name = "from", .unit = "m", .text = "centre of one round end of each capsule"}, from);
    f.visit({.name = "to", .unit = "m", .text = "centre of the other"}, to);
    f.visit({.name = "radii", .unit = "m", .text = "of each capsule", .above = 0}, radii);
}

void BoxParts::fields(FieldVisitor& f) {
    f.visit({.name = "centres", .unit = "m", .text = "of each box; of a single one the origin where absent"}, centres);
    f.visit({.name = "sizes", .unit = "m", .text = "of each box along the axes of the frame, with its rounded edges"},
            sizes);
    f.visit({.name = "radii",
             .unit = "m",
             .text = "of the edges of each box: of contacts with it, a depth that counts as rods' radii do",
             .above = 0},
            radii);
}

void BodySpec::fields(FieldVisitor& f) {
    f.visit({.name = "mass", .unit = "kg", .text = "instead of a density", .at_least = 0}, mass);
    f.visit_optional({.name = "centre", .unit = "m", .text = "centre of mass; that of the parts where absent"}, centre);
    f.visit({.name = "inertia",
             .unit = "kg m^2",
             .text = "about the centre of mass, along the axes of the parts: J_xx, J_yy, J_zz, or these and J_xy, "
                     "J_xz, J_yz (the "
                     "elements of the matrix); that of the parts where absent"},
            inertia);
    f.table({.name = "spheres", .unit = "", .text = ""}, spheres);
    f.table({.name = "capsules", .unit = "", .text = ""}, capsules);
    f.table({.name = "boxes", .unit = "", .text = ""}, boxes);
}

} // namespace skein
