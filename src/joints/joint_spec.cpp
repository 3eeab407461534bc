#include "joints/joint_spec.hpp"

#include "time/stage_spec.hpp"

#include <cmath>

namespace skein {

namespace {

/// Rate of turning of R(p), in its own axes, from the rate of p.
Vec3d turning_of(const Vec3d& p, const Vec3d& rate) {
    const double angle = norm(p), squared = angle * angle;
    if (angle < 1e-4) return rate - 0.5 * cross(p, rate) + (1.0 / 6) * cross(p, cross(p, rate));
    return rate - ((1 - std::cos(angle)) / squared) * cross(p, rate) +
           ((angle - std::sin(angle)) / (squared * angle)) * cross(p, cross(p, rate));
}

} // namespace

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

MotorsNow JointSpec::motors_at(double time) const {
    if (!has_motor()) return {};
    if (kind == JointKind::spherical) {
        const MotorsNow lab = axis_law.motor.vector_at(time);
        const Vec3d n = twist_axis(), u = across_twist(), w = cross(n, u);
        // Of the world against the first it is the opposite, and so are n and u.
        const auto own = [&](const Vec3d& v) {
            return Vec3d{dot(n, v), dot(u, v), to_world() ? -dot(w, v) : dot(w, v)};
        };
        const Vec3d p = own(lab.value);
        return {p, turning_of(p, own(lab.rate))};
    }
    MotorsNow now;
    const auto set = [&](const Motor& motor, double Vec3d::*axis) {
        if (motor.kind == MotorKind::none) return;
        const MotorNow one = motor.at(time);
        now.value.*axis = one.value;
        now.rate.*axis = one.rate;
    };
    set(axis_law.motor, &Vec3d::x);
    set(about_second.motor, &Vec3d::y);
    return now;
}

void JointSpec::fields(FieldVisitor& f) {
    f.choice(
        {.name = "kind",
         .unit = "",
         .text =
             "spherical: two points stay together; hinge: and an axis; fixed: and both frames; side_by_side: sides of "
             "neighbouring elements; tip_to_side: an end and the nearest side, as a hinge about the end's own axis; "
             "universal: two points, and two axes at right angles; slider: both frames, while a point moves along "
             "`axis`; distance: two points keep their distance; bushing: springs and dashpots along and about d1, d2, "
             "d3 of "
             "the first, in shares of their numbers",
         .required = true},
        kind, joint_names);
    f.visit(
        {.name = "between",
         .unit = "",
         .text =
             "two groups outside assemblies, or of one assembly; twice the same; or a group and \"world\", to which "
             "places of its rods are joined where they start, in each copy",
         .required = true},
        between);
    f.visit({.name = "name",
             .unit = "",
             .text =
                 "adds columns to the time series: the largest force [N] that one of its joints carries, NAME_force, "
                 "and the widest gap [m], NAME_gap"},
            name);
    f.choice({.name = "pairs",
              .unit = "",
              .text = "spherical, hinge, fixed: which rods are joined, by their numbers in a copy: i and i, i and i + "
                      "1, or listed"},
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
             .text = "when it is made, where both sides are then and free of strain; 0: at the start, as the scene "
                     "places them",
             .at_least = 0},
            from);
    f.visit({.name = "until", .unit = "s", .text = "when it lets go; 0: never", .at_least = 0}, until);
    f.visit({.name = "break_force",
             .unit = "N",
             .text = "it breaks for good where it carries more than this; 0: never",
             .at_least = 0},
            break_force);
}

void JointSpec::place_fields(FieldVisitor& f) {
    f.visit(
        {.name = "at",
         .unit = "-",
         .text =
             "where both are joined, over their length: 0 is the start, 1 the end; a body is joined where the rod is, "
             "to the world at its centre of mass; tip_to_side: 0 or 1, the end of the first",
         .at_least = 0,
         .at_most = 1},
        at);
    f.visit_optional(
        {.name = "place",
         .unit = "m",
         .text = "of one joint of a kind with one point: place at the start, in the axes of the assembly, from which "
                 "arms go to both; absent: midway between both places, or that of the rod"},
        place);
    f.visit(
        {.name = "axis",
         .unit = "-",
         .text =
             "hinge, slider, universal, spherical: direction at the start, in the axes of the assembly; of universal "
             "it is fixed in the first, of spherical that of `cone` and of the twist. Angles and ways are those of the "
             "second against the first, of a rod or body "
             "against the world"},
        axis);
    f.visit({.name = "second_axis", .unit = "-", .text = "universal: direction that is fixed in the second"},
            second_axis);
    f.visit({.name = "length", .unit = "m", .text = "distance: of the points; 0: as at the start", .at_least = 0},
            length);
    f.visit({.name = "gap",
             .unit = "m",
             .text = "side_by_side: elements are joined whose surfaces are at most so far apart at the start; 0: 1 % "
                     "of their radii",
             .at_least = 0},
            gap);
}

void JointLaw::fields(FieldVisitor& f) {
    f.visit(
        {.name = "stiffness",
         .unit = "N/m",
         .text =
             "k, of the spring between both points; of all kinds but fixed by number. \"auto\", of fixed joints: the "
             "two places are one node, and the halves of elements beside it bend and twist as within a rod "
             "(docs/theory.md "
             "22)",
         .above = 0,
         .automatic = 0},
        stiffness);
    f.visit({.name = "damping", .unit = "N s/m", .text = "of their relative velocity", .at_least = 0}, damping);
    f.visit({.name = "torsional_stiffness",
             .unit = "N m/rad",
             .text = "hinge, fixed, tip_to_side, universal, slider: of the spring that turns back; a fixed joint with "
                     "stiffness = "
                     "\"auto\" has it only "
                     "where it is given, in the place of the half elements",
             .at_least = 0},
            torsional_stiffness);
    f.visit({.name = "torsional_damping",
             .unit = "N m s/rad",
             .text = "of all with a torsional_stiffness: of the relative spin",
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
             .text = "bushing: shares of torsional_stiffness and torsional_damping about them",
             .at_least = 0,
             .at_most = 1},
            about);
    f.visit({.name = "repulsion",
             .unit = "N/m^1.5",
             .text = "side_by_side, tip_to_side: k_r of a force k_r d^1.5 that parts elements whose centres are by d "
                     "closer than "
                     "at the start",
             .at_least = 0},
            repulsion);
    f.visit({.name = "rope", .unit = "", .text = "distance: it pulls and never pushes"}, rope);
    f.visit({.name = "cone",
             .unit = "rad",
             .text = "spherical: largest angle by which `axis` of one side leaves that of the other, with the stops of "
                     "`limits`; 0: without limit",
             .at_least = 0,
             .at_most = 2.5},
            cone);
}

} // namespace skein
