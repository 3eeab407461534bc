#include "contact/wall.hpp"

#include "skein/core/error.hpp"
#include "time/stage_spec.hpp"

#include <algorithm>

namespace skein {

namespace {

[[noreturn]] void refuse(const Wall& wall, const std::string& what) {
    throw InputError((wall.source.empty() ? "" : wall.source + ": ") + "wall '" + wall.name + "': " + what);
}

Vec3d unit(const Wall& wall, const Vec3d& a, const char* what) {
    const double size = norm(a);
    if (!(size > 0)) refuse(wall, std::string(what) + " has no direction");
    return (1 / size) * a;
}

void add_sides(const Wall& box, std::vector<Wall>& out) {
    for (const std::string& side : box.open)
        if (std::find(std::begin(box_side_names), std::end(box_side_names), side) == std::end(box_side_names))
            refuse(box, "a box has no side '" + side + "'; sides are x-, x+, y-, y+, z-, z+");
    const double lower[] = {box.lower.x, box.lower.y, box.lower.z}, upper[] = {box.upper.x, box.upper.y, box.upper.z};
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2;
        if (!(lower[axis] < upper[axis]))
            refuse(box, "the upper corner must lie beyond the lower one in every direction");
        if (!has_side(box, box_side_names[side])) continue;
        const double inward = side % 2 ? -1 : 1;
        Wall plane = box;
        plane.name += " " + std::string(box_side_names[side]);
        plane.kind = WallKind::plane;
        plane.point = side % 2 ? box.upper : box.lower;
        plane.normal = {axis == 0 ? inward : 0, axis == 1 ? inward : 0, axis == 2 ? inward : 0};
        plane.open.clear();
        out.push_back(plane);
    }
}

} // namespace

void ServoSpec::fields(FieldVisitor& f) {
    f.visit({.name = "speed",
             .unit = "m/s",
             .text = "speed along the wall's velocity, or, without one, along the normal of the plane",
             .required = true,
             .above = 0},
            speed);
    f.visit({.name = "watch",
             .unit = "",
             .text = "name of the wall whose stress controls the motion; for a box, one side, such as \"box z-\"",
             .required = true},
            watch);
    f.visit({.name = "area",
             .unit = "m^2",
             .text = "area by which the force on the watched wall is divided",
             .required = true,
             .above = 0},
            area);
    f.visit({.name = "turn_back_above",
             .unit = "Pa",
             .text = "stress at which the wall moves back; it includes the weight of the rods",
             .required = true},
            turn_back_above);
    f.visit({.name = "turn_forth_below",
             .unit = "Pa",
             .text = "stress below which the wall moves forward again; it includes the weight of the rods",
             .required = true},
            turn_forth_below);
    f.visit({.name = "not_before",
             .unit = "m",
             .text = "the wall moves forward again only if its point, measured against the forward direction, is above "
                     "this; for a lid that moves down z, the height"},
            not_before);
    f.visit({.name = "cycles",
             .unit = "-",
             .text = "number of cycles forward and back before it stops; 0: no end",
             .at_least = 0},
            cycles);
    f.visit({.name = "average",
             .unit = "s",
             .text = "time constant of the exponential average of the stress, which jumps when rods hit the watched "
                     "wall; 0: no average",
             .at_least = 0},
            average);
    f.visit({.name = "approach",
             .unit = "m/s",
             .text = "initial speed, until something touches the wall or it reaches approach_to; 0: equal to speed",
             .at_least = 0},
            approach);
    f.visit({.name = "approach_to",
             .unit = "m",
             .text = "position of its point, measured against the forward direction, at which the approach ends"},
            approach_to);
    f.visit({.name = "ends_run", .unit = "", .text = "true: the run ends with the last cycle"}, ends_run);
}

void Wall::fields(FieldVisitor& f) {
    f.visit({.name = "name", .unit = "", .text = "name of the wall, in tables and for servos", .required = true}, name);
    f.choice({.name = "kind", .unit = "", .text = "shape of the wall", .required = true}, kind, wall_names);
    f.visit({.name = "point",
             .unit = "m",
             .text = "a point on the plane, a point on the axis of the tube, or the centre of the ball"},
            point);
    f.visit({.name = "normal", .unit = "-", .text = "plane: normal, towards the rods"}, normal);
    f.visit({.name = "axis", .unit = "-", .text = "tube: direction of its axis"}, axis);
    f.visit({.name = "radius", .unit = "m", .text = "tube, ball: radius", .at_least = 0}, radius);
    f.choice({.name = "side", .unit = "", .text = "tube, ball: side of the rods"}, side, wall_side_names);
    f.visit({.name = "lower", .unit = "m", .text = "box: corner with the smallest coordinates; rods are inside"},
            lower);
    f.visit({.name = "upper", .unit = "m", .text = "box: corner with the largest coordinates"}, upper);
    f.visit({.name = "open", .unit = "", .text = "box: sides left open, of x-, x+, y-, y+, z-, z+"}, open);
    law.fields(f);
    f.visit({.name = "rods", .unit = "", .text = "groups on which it acts; default: all"}, rods);
    f.choice({.name = "touches",
              .unit = "",
              .text = "part of the rods that touches the wall; surface: with round ends; axis: the centreline, without "
                      "width and round ends"},
             touches, wall_touch_names);
    f.visit({.name = "allow_overlap",
             .unit = "",
             .text = "true: free nodes may start behind the wall, or in it by more than 0.1 of the diameter; with "
                     "soft_until they may in any case"},
            allow_overlap);
    f.visit({.name = "velocity",
             .unit = "m/s",
             .text = "constant velocity of the wall; with a servo, its forward direction"},
            velocity);
    f.visit({.name = "from", .unit = "s", .text = "time at which the wall begins to move", .at_least = 0}, from);
    f.visit(stages_field, stages);
    f.table({.name = "servo", .unit = "", .text = "moves the wall forward and back by the stress on a wall"}, servo);
}

bool Wall::acts_on(const std::string& group) const {
    return rods.empty() || std::find(rods.begin(), rods.end(), group) != rods.end();
}

bool has_side(const Wall& box, std::string_view side) {
    return std::find(box.open.begin(), box.open.end(), side) == box.open.end();
}

std::vector<Wall> expanded(const std::vector<Wall>& walls) {
    std::vector<Wall> out;
    for (const Wall& wall : walls) {
        if (wall.servo.drives() && wall.kind != WallKind::plane && !(dot(wall.velocity, wall.velocity) > 0))
            refuse(wall, "a servo needs a velocity for its direction, unless it drives a plane");
        if (wall.kind == WallKind::box) {
            add_sides(wall, out);
            continue;
        }
        Wall& one = out.emplace_back(wall);
        if (wall.kind == WallKind::plane) one.normal = unit(wall, wall.normal, "the normal");
        if (wall.kind == WallKind::tube) one.axis = unit(wall, wall.axis, "the axis");
        if (wall.kind != WallKind::plane && !(wall.radius > 0)) refuse(wall, "needs a radius above 0");
    }
    for (const Wall& wall : out) {
        const auto named = [](const std::string& name) { return [&name](const Wall& w) { return w.name == name; }; };
        if (std::count_if(out.begin(), out.end(), named(wall.name)) > 1) refuse(wall, "two walls have this name");
        if (wall.servo.drives() && std::none_of(out.begin(), out.end(), named(wall.servo.watch)))
            refuse(wall, "there is no wall '" + wall.servo.watch + "' to watch");
    }
    return out;
}

WallState Walls::at(std::size_t w, double time) const {
    const Wall& one = wall[w];
    if (one.servo.drives()) return state[w];
    if (!one.moves_steadily() || time < one.from) return {one.moved, {0, 0, 0}};
    return {one.moved + (time - one.from) * one.velocity, one.velocity};
}

WallState Walls::within_step(std::size_t w, double time) const {
    WallState now = at(w, time);
    if (wall[w].servo.drives()) now.offset = now.offset + (time - state_time) * now.velocity;
    return now;
}

int Walls::find(const std::string& name) const {
    for (std::size_t w = 0; w < count(); ++w)
        if (wall[w].name == name) return static_cast<int>(w);
    return -1;
}

} // namespace skein
