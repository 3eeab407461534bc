#include "joints/joint_spec.hpp"

#include "mechanics/moving_ends.hpp"
#include "time/stage_spec.hpp"

#include <cmath>

namespace skein {

Vec3d JointSpec::twist_axis() const { return zero(axis) ? Vec3d{0, 0, 1} : unit(axis); }

Vec3d JointSpec::across_twist() const {
    const Vec3d n = twist_axis(), size{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
    const Vec3d least = size.x <= size.y && size.x <= size.z ? Vec3d{1, 0, 0}
                        : size.y <= size.z                   ? Vec3d{0, 1, 0}
                                                             : Vec3d{0, 0, 1};
    return unit(cross(n, least));
}

void JointSpec::use(const FormulaScope& names) {
    for (AxisSpec* law : {&axis_law, &about_second}) law->motor.use(names, turns_freely(kind));
}

MotorsNow<double> JointSpec::along_own_directions(const MotorsNow<double>& lab) const {
    const Vec3d n = twist_axis(), u = across_twist(), w = cross(n, u);
    // The turn of the world against the first is the opposite, and so are n and u.
    const auto own = [&](const Vec3d& v) { return Vec3d{dot(n, v), dot(u, v), to_world() ? -dot(w, v) : dot(w, v)}; };
    const Vec3d p = own(lab.value);
    return {p, spin_of(-p, own(lab.rate))}; // in the axes of R(p)
}

MotorsNow<double> JointSpec::motors_at(double time, double rod) const {
    if (!has_motor()) return {};
    if (kind == JointKind::spherical) return along_own_directions(axis_law.motor.vector_at(time, rod));
    MotorsNow<double> now;
    const auto set = [&](const Motor& motor, double Vec3d::*axis) {
        if (motor.kind == MotorKind::none) return;
        const MotorNow<double> one = motor.at(time, rod);
        now.value.*axis = one.value;
        now.rate.*axis = one.rate;
    };
    set(axis_law.motor, &Vec3d::x);
    set(about_second.motor, &Vec3d::y);
    now.cosine = std::cos(0.5 * now.value.x);
    now.sine = std::sin(0.5 * now.value.x);
    return now;
}

void JointSpec::fields(FieldVisitor& f) {
    f.choice(
        {.name = "kind",
         .unit = "",
         .text = "spherical: joins two points; hinge: two points and an axis; fixed: two points and both frames; "
                 "side_by_side: sides of neighbouring elements; tip_to_side: an end and the nearest side, like a hinge "
                 "about the end's own axis; universal: two points, with two axes at right angles; slider: both frames, "
                 "with one point free along `axis`; distance: keeps the distance of two points; bushing: springs and "
                 "dashpots along and about d1, d2, d3 of the first, in shares of the given numbers",
         .required = true},
        kind, joint_names);
    f.visit({.name = "between",
             .unit = "",
             .text = "two groups, both outside assemblies or both of one assembly; one group twice; or a group and "
                     "\"world\": places of its rods are joined to their positions at the start, in each copy",
             .required = true},
            between);
    f.visit({.name = "name",
             .unit = "",
             .text =
                 "adds columns to the time series: NAME_force, the largest force [N] that one of its joints carries, "
                 "and NAME_gap, the widest gap [m]"},
            name);
    f.choice({.name = "pairs",
              .unit = "",
              .text = "spherical, hinge, fixed: numbers of the joined rods in a copy; same: i and i; next: i and i + "
                      "1; listed: in `first` and `second`"},
             pairs, joint_pairs_names);
    f.visit({.name = "first", .unit = "-", .text = "listed: numbers of rods of the first group", .at_least = 0}, first);
    f.visit({.name = "second", .unit = "-", .text = "listed: numbers of rods of the second group", .at_least = 0},
            second);
    place_fields(f);
    law.fields(f);
    axis_law.fields(f);
    f.table({.name = "about_second"}, about_second);
    events.fields(f);
    f.visit(stages_field, stages);
}

void JointEvents::fields(FieldVisitor& f) {
    f.visit({.name = "from",
             .unit = "s",
             .text = "time at which the joint is made, free of strain at the positions then; 0: at the start, at the "
                     "positions of the scene",
             .at_least = 0},
            from);
    f.visit({.name = "until", .unit = "s", .text = "time at which the joint is released; 0: never", .at_least = 0},
            until);
    f.visit({.name = "break_force",
             .unit = "N",
             .text = "force above which the joint breaks permanently; 0: never",
             .at_least = 0},
            break_force);
    f.visit({.name = "break_strain",
             .unit = "-",
             .text =
                 "mean axial strain of the two elements beside a common node, stiffness = \"auto\", above which rods "
                 "tear permanently; 0: never",
             .at_least = 0},
            break_strain);
}

void JointSpec::place_fields(FieldVisitor& f) {
    f.visit({.name = "at",
             .unit = "-",
             .text =
                 "places of the joint on both, over their length: 0 is the start, 1 the end; a body is joined at the "
                 "place on the rod, or to the world at its centre of mass; tip_to_side: 0 or 1, the end of the first",
             .at_least = 0,
             .at_most = 1},
            at);
    f.visit_optional(
        {.name = "place",
         .unit = "m",
         .text = "for a single joint of a kind with one point: its place at the start, in the axes of the assembly, "
                 "with arms to both sides; default: midway between both places, or the place on the rod"},
        place);
    f.visit({.name = "axis",
             .unit = "-",
             .text = "hinge, slider, universal, spherical: direction at the start, in the axes of the assembly; for "
                     "universal it is fixed in the first, for spherical it is the axis of `cone` and of the twist. "
                     "Angles and displacements are of the second relative to the first, or of a "
                     "rod or body relative to the world"},
            axis);
    f.visit({.name = "second_axis", .unit = "-", .text = "universal: direction fixed in the second"}, second_axis);
    f.visit({.name = "length",
             .unit = "m",
             .text = "distance: distance of the points; 0: distance at the start",
             .at_least = 0},
            length);
    f.visit(
        {.name = "gap",
         .unit = "m",
         .text =
             "side_by_side: largest gap between the surfaces of joined elements at the start; 0: 1 % of their radii",
         .at_least = 0},
        gap);
}

void JointLaw::fields(FieldVisitor& f) {
    f.visit({.name = "stiffness",
             .unit = "N/m",
             .text = "k, stiffness of the spring between both points; all kinds except fixed need a number. \"auto\" "
                     "(fixed joints): the two places are one node, and the half elements beside it bend and twist as "
                     "within a rod (docs/theory.md 22)",
             .above = 0,
             .automatic = 0},
            stiffness);
    f.visit(
        {.name = "damping", .unit = "N s/m", .text = "damping of the relative velocity of both points", .at_least = 0},
        damping);
    f.visit({.name = "torsional_stiffness",
             .unit = "N m/rad",
             .text =
                 "hinge, fixed, tip_to_side, universal, slider: stiffness of the restoring torsional spring. A fixed "
                 "joint with stiffness = \"auto\" has this spring only if it is given; it replaces the half elements",
             .at_least = 0},
            torsional_stiffness);
    f.visit({.name = "torsional_damping",
             .unit = "N m s/rad",
             .text = "kinds with a torsional_stiffness: damping of the relative spin",
             .at_least = 0},
            torsional_damping);
    f.visit({.name = "along",
             .unit = "-",
             .text = "bushing: shares of stiffness and damping along d1, d2, d3 of the first, or the axes of a body",
             .at_least = 0,
             .at_most = 1},
            along);
    f.visit({.name = "about",
             .unit = "-",
             .text = "bushing: shares of torsional_stiffness and torsional_damping about these axes",
             .at_least = 0,
             .at_most = 1},
            about);
    f.visit({.name = "repulsion",
             .unit = "N/m^1.5",
             .text = "side_by_side, tip_to_side: k_r of a repulsive force k_r d^1.5 between elements whose centres are "
                     "closer by d than at the start",
             .at_least = 0},
            repulsion);
    f.visit({.name = "rope", .unit = "", .text = "distance: true: the joint only pulls, like a rope"}, rope);
    f.visit({.name = "cone",
             .unit = "rad",
             .text =
                 "spherical: largest angle between `axis` of one side and of the other, with the stops of `limits`; "
                 "0: no limit",
             .at_least = 0,
             .at_most = 2.5},
            cone);
}

} // namespace skein
