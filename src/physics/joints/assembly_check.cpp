#include "physics/joints/joint_tables.hpp"

#include "core/nearest.hpp"
#include "formula/formula.hpp"
#include "joints/junction.hpp"
#include "physics/assemblies.hpp"
#include "physics/group_names.hpp"
#include "physics/rods/placement_check.hpp"
#include "physics/scene_spec.hpp"
#include "physics/table_objections.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace skein {

namespace {

/// Keys that have no use in the copies of an assembly.
void member(const SceneSpec& scene, const RodSpec& rods, Objections& objections) {
    std::vector<std::string_view> names;
    for (const AssemblySpec& assembly : scene.assemblies) names.push_back(assembly.name);
    const int assembly = assembly_named(scene, rods.assembly);
    if (assembly < 0)
        return objections.add("assembly",
                              fmt::format("there is no assembly '{}'{}", rods.assembly,
                                          names.empty() ? "" : suggestion(rods.assembly, names, "the assemblies are")));
    const Placement& copies = nth(scene.assemblies, assembly).placement;
    const bool turned = !copies.tangents.empty() || copies.normal || norm(copies.tangent - Vec3d{0, 0, 1}) > 0;
    if (turned && rods.ends_move() && !(rods.start_free.empty() && rods.end_free.empty()))
        objections.add("",
                       "ends slide in lab directions and are moved in the axes of copies, which differ where copies "
                       "are turned: leave out 'start_free' and 'end_free', or the motion");
}

void to_world(const JointSpec& spec, const RodSpec& rods, Objections& objections) {
    const JointKind kind = spec.kind;
    if (kind == JointKind::side_by_side || kind == JointKind::tip_to_side)
        objections.add("kind", fmt::format("the world has no sides: a joint of kind \"{}\" is between rods",
                                           nth(joint_names, kind)));
    if (spec.pairs == JointPairs::next) objections.add("pairs", "the world has no numbers: leave 'pairs' out, or list");
    if (shares_node(spec))
        objections.add("", rods.body
                               ? "a body that is fixed to the world does not move: leave the joint out and give "
                                 "'stiffness' [N/m] and 'torsional_stiffness' [N m/rad], or use a [[wall]]"
                               : "a rod that is fixed to the world is clamped: say start or end = \"clamped\", or "
                                 "'hold', or give 'stiffness' [N/m] and 'torsional_stiffness' [N m/rad]");
}

void check_axes(const JointSpec& spec, Objections& objections, const std::string& where) {
    const bool of_cone = spec.kind == JointKind::spherical;
    if (of_cone && spec.law.cone == 0) objections.unused({"axis"}, where + " without 'cone'");
    else if (!has_axis(spec.kind) && !of_cone) objections.unused({"axis"}, where);
    else if (zero(spec.axis)) objections.add("axis", fmt::format("'axis', a direction, is needed {}", where));
    if (spec.kind != JointKind::universal) return objections.unused({"second_axis"}, where);
    if (zero(spec.second_axis))
        return objections.add("", fmt::format("'second_axis', a direction, is needed {}", where));
    if (!zero(spec.axis) && std::abs(dot(unit(spec.axis), unit(spec.second_axis))) > 1e-6)
        objections.add("second_axis", "'axis' and 'second_axis' must be at right angles");
}

void check_motor(const SceneSpec& scene, const JointSpec& spec, const Motor& motor, Objections& objections) {
    TableObjections table(objections, "motor");
    if (motor.kind == MotorKind::none)
        return table.unused({"value", "values", "stiffness", "damping", "most"}, "without 'kind'");
    const std::string kind(nth(motor_names, motor.kind));
    const bool ball = spec.kind == JointKind::spherical;
    const char* const key = ball ? "values" : "value";
    table.unused({ball ? "value" : "values"}, fmt::format("for a joint of kind \"{}\"", nth(joint_names, spec.kind)));
    if (ball && motor.values.size() != 3)
        return table.add(
            "", fmt::format("a motor of kind \"{}\" of a spherical joint needs 'values', three formulas", kind));
    if (!ball && motor.value.empty()) return table.add("", fmt::format("a motor of kind \"{}\" needs 'value'", kind));
    if (motor.kind == MotorKind::position && motor.stiffness == 0)
        table.add("", "a motor of kind \"position\" needs 'stiffness'");
    if (motor.kind == MotorKind::rate && motor.damping == 0) table.add("", "a motor of kind \"rate\" needs 'damping'");
    if (motor.kind != MotorKind::position) table.unused({"stiffness"}, fmt::format("for a motor of kind \"{}\"", kind));
    if (motor.kind == MotorKind::force) table.unused({"damping"}, "for a motor of kind \"force\"");
    Motor read = motor;
    FormulaScope names = names_for_formulas(scene);
    const JointEvents& events = spec.events;
    names.acts = names.acts.within({events.from, events.until > 0 ? events.until : names.duration});
    read.use(names, turns_freely(spec.kind));
    if (ball) return add_faults(key, read.faults(), table);
    for (const FormulaFault& fault : read.faults()) {
        const std::string message = fmt::format("'value': {}", fault.message);
        if (fault.part.formula < 0) table.add("value", message);
        else table.add_within("value", fault.part.begin, fault.part.length, message);
    }
}

void check_limits(const JointSpec& spec, const AxisSpec& axis, Objections& objections) {
    if (axis.limits.empty() && spec.law.cone == 0)
        return objections.unused({"stop_stiffness", "stop_damping"}, "without 'limits'");
    const bool ball = spec.kind == JointKind::spherical;
    if (!axis.limits.empty()) {
        if (axis.limits.size() != 2 || !(axis.limits[0] < axis.limits[1]))
            return objections.add("limits", "'limits' needs two numbers, the least and the largest");
        if (ball && (axis.limits[0] < -3 || axis.limits[1] > 3))
            return objections.add(
                "limits", "a twist beyond 3 rad cannot be distinguished from one in the other direction: 'limits' "
                          "lie between -3 and 3");
        if (ball && spec.law.cone == 0)
            return objections.add("limits", "the twist of a spherical joint has no meaning where its axis is turned "
                                            "round: 'limits' need 'cone'");
    }
    if (axis.stop_stiffness == 0)
        objections.add("", fmt::format("'{}' need{} 'stop_stiffness'", axis.limits.empty() ? "cone" : "limits",
                                       axis.limits.empty() ? "s" : ""));
}

/// Springs, stops, friction and motor along a free axis.
void check_free_axis(const SceneSpec& scene, const JointSpec& spec, const AxisSpec& axis, Objections& objections) {
    if (axis.spring == 0) objections.unused({"spring_rest"}, "without 'spring'");
    else if (spec.kind == JointKind::spherical)
        objections.unused({"spring_rest"}, "of a spherical joint, whose spring rests at the start");
    check_limits(spec, axis, objections);
    if (axis.friction == 0) objections.unused({"friction_stiffness", "friction_damping"}, "without 'friction'");
    else if (axis.friction_stiffness == 0)
        objections.add("", "'friction' needs 'friction_stiffness', of the spring by which it holds");
    if (kicks_backwards(scene.time.integrator) &&
        (axis.friction > 0 || axis.damping > 0 || axis.stop_damping > 0 || axis.motor.damping > 0))
        objections.add("", "friction and dashpots of joints need integrator = \"verlet\": the kicks of \"pefrl\" go "
                           "backwards too");
    check_motor(scene, spec, axis.motor, objections);
}

void check_free_axes(const SceneSpec& scene, const JointSpec& spec, Objections& objections, const std::string& where) {
    if (!has_free_axis(spec.kind)) {
        objections.unused({"spring", "axis_damping", "limits", "friction"}, where);
        if (spec.axis_law.motor.kind != MotorKind::none)
            objections.add("motor", fmt::format("a motor drives a free axis, and a joint of kind \"{}\" has none",
                                                nth(joint_names, spec.kind)));
    }
    if (spec.kind != JointKind::spherical) objections.unused({"cone"}, where);
    check_free_axis(scene, spec, spec.axis_law, objections);
    if (spec.kind != JointKind::universal) return objections.unused({"about_second"}, where);
    TableObjections second(objections, "about_second");
    check_free_axis(scene, spec, spec.about_second, second);
}

void check_events(const SceneSpec& scene, const JointSpec& spec, Objections& objections) {
    const JointEvents& events = spec.events;
    if (!spec.stages.empty()) objections.unused({"from", "until"}, "with 'stages', from which both follow");
    if (!events.any() && spec.stages.empty()) return;
    if (events.until > 0 && events.until <= events.from)
        objections.add("until", fmt::format("it would let go before it is made, at {:g} s", events.from));
    const bool held = events.from > 0 || events.until > 0 || events.break_force > 0 || !spec.stages.empty();
    if (shares_node(spec) && held)
        objections.add("", "places that are one node, with stiffness = \"auto\", stay so: for 'from', 'until' and "
                           "'break_force' give 'stiffness' [N/m] and 'torsional_stiffness' [N m/rad]");
    if (!shares_node(spec))
        objections.unused({"break_strain"}, "with 'stiffness' [N/m]: 'break_force' breaks such joints");
    else if (tears(spec) && has_springs(spec))
        objections.add("break_strain", "rods that tear have no springs or dashpots beside their common node: leave out "
                                       "'torsional_stiffness' and 'torsional_damping'");
    if (kicks_backwards(scene.time.integrator))
        objections.add("",
                       "joints that are made or come to an end need integrator = \"verlet\", which evaluates forces "
                       "once a step");
}

void joint(const SceneSpec& scene, const JointSpec& spec, Objections& objections) {
    const JointKind kind = spec.kind;
    const std::string where = fmt::format("for a joint of kind \"{}\"", nth(joint_names, kind));
    if (spec.between.size() != 2)
        return objections.add("between", "'between' names two groups, twice the same, or a group and \"world\"");
    std::vector<const RodSpec*> groups;
    for (std::size_t i = 0; i < 2; ++i)
        groups.push_back(i == 1 && spec.to_world()
                             ? groups[0]
                             : group_named(scene, spec.between[i], objections, fmt::format("between.{}", i)));
    if (!groups[0] || !groups[1]) return;
    if (spec.to_world()) to_world(spec, *groups[0], objections);
    if (groups[0]->assembly != groups[1]->assembly)
        objections.add("between",
                       fmt::format("'{}' and '{}' belong to different assemblies: joints are between rods of one copy",
                                   spec.between[0], spec.between[1]));
    const bool points = joins_places(kind);
    if (!points) objections.unused({"pairs", "first", "second"}, where);
    else if (spec.pairs != JointPairs::listed) objections.unused({"first", "second"}, "without pairs = \"listed\"");
    else if (spec.to_world() ? spec.first.empty() || !spec.second.empty()
                             : spec.first.empty() || spec.first.size() != spec.second.size())
        objections.add("", spec.to_world()
                               ? "'first' lists rods that are joined to the world, and 'second' none"
                               : fmt::format("'first' and 'second' list as many rods each, at least one: they have {} "
                                             "and {}",
                                             spec.first.size(), spec.second.size()));
    if (!points || (kind == JointKind::distance && !spec.to_world())) objections.unused({"place"}, where);
    if (spec.at.size() != 2 && !(spec.to_world() && spec.at.size() == 1))
        objections.add("at", "'at' needs two values, a place on each of both; to the world one");
    else if (kind == JointKind::tip_to_side && spec.at[0] != 0 && spec.at[0] != 1)
        objections.add("at", "the tip is at the start or the end of the first rod: at[0] is 0 or 1");
    if (kind == JointKind::side_by_side) objections.unused({"at", "torsional_stiffness", "torsional_damping"}, where);
    if (kind == JointKind::spherical || kind == JointKind::distance)
        objections.unused({"torsional_stiffness", "torsional_damping"}, where);
    if (kind != JointKind::distance) objections.unused({"length", "rope"}, where);
    if (kind != JointKind::bushing) objections.unused({"along", "about"}, where);
    check_axes(spec, objections, where);
    check_free_axes(scene, spec, objections, where);
    check_events(scene, spec, objections);
    if (kind != JointKind::side_by_side && kind != JointKind::tip_to_side)
        objections.unused({"repulsion", "gap"}, where);
    const bool common_node = shares_node(spec);
    if (kind != JointKind::fixed && spec.law.stiffness == 0)
        objections.add("", fmt::format("'stiffness' [N/m] is needed by number {}", where));
    if (common_node) objections.unused({"damping"}, "of two places that are one node, with stiffness = \"auto\"");
    if ((kind == JointKind::fixed || has_axis(kind)) && spec.law.torsional_stiffness == 0 && !common_node)
        objections.add(
            "", fmt::format("'torsional_stiffness' [N m/rad] is needed {}{}", where,
                            kind == JointKind::fixed ? " whose 'stiffness' is a number; both may be left out" : ""));
    if (common_node && kicks_backwards(scene.time.integrator) && (groups[0]->body || groups[1]->body))
        objections.add("stiffness",
                       "a rod and a body have a common node in steps of time.integrator = \"verlet\" alone: leave that "
                       "out, or give 'stiffness' [N/m] and 'torsional_stiffness' [N m/rad]");
    const auto body = [&](std::size_t i) { return groups[i]->body.has_value(); };
    if (!points && (body(0) || body(1)))
        objections.add("between", fmt::format("bodies have no elements side by side {}", where));
}

void check_assemblies(const SceneSpec& scene, Objections& objections) {
    for (std::size_t a = 0; a < scene.assemblies.size(); ++a) {
        const AssemblySpec& spec = scene.assemblies[a];
        TableObjections table(objections, fmt::format("assembly.{}", a));
        if (!good_name(spec.name))
            table.add("name", fmt::format("'{}' cannot name an assembly: use letters, digits, _ and -", spec.name));
        for (std::size_t b = 0; b < a; ++b)
            if (scene.assemblies[b].name == spec.name)
                table.add("name", fmt::format("two assemblies are named '{}'", spec.name));
        if (std::none_of(scene.rods.begin(), scene.rods.end(),
                         [&](const RodSpec& rods) { return rods.assembly == spec.name; }))
            table.add("name",
                      fmt::format("no group belongs to the assembly '{}': say assembly = \"{}\" in its [[rods]]",
                                  spec.name, spec.name));
        if (spec.placement.kind == PlacementKind::packing || spec.placement.kind == PlacementKind::file)
            table.add("placement.kind", fmt::format("assemblies are not placed by kind \"{}\" yet: list their origins",
                                                    nth(placement_names, spec.placement.kind)));
        RodSpec placed;
        placed.placement = spec.placement;
        check_placement(placed, table);
        if (zero(spec.scatter) && spec.magnetisation_scatter == 0)
            table.unused({"seed"}, "without 'scatter' or 'magnetisation_scatter'");
    }
    for (std::size_t i = 0; i < scene.rods.size(); ++i) {
        if (scene.rods[i].assembly.empty()) continue;
        TableObjections table(objections, path_of_group(scene, i));
        member(scene, scene.rods[i], table);
    }
}

/// Names of columns, which walls have too.
void check_name(const SceneSpec& scene, std::size_t j, Objections& objections) {
    const JointSpec& spec = scene.joints[j];
    if (spec.name.empty()) return;
    if (!good_name(spec.name) || spec.name == "joint")
        objections.add("name",
                       fmt::format("'{}' cannot name a joint: use letters, digits, _ and -, and another word than "
                                   "\"joint\"",
                                   spec.name));
    const auto named = [&](const auto& other) { return other.name == spec.name; };
    if (std::any_of(scene.joints.begin(), scene.joints.begin() + static_cast<std::ptrdiff_t>(j), named))
        objections.add("name", fmt::format("two joints are named '{}'", spec.name));
    if (std::any_of(scene.walls.begin(), scene.walls.end(), named))
        objections.add("name", fmt::format("a wall is named '{}' too, and has a column of that name", spec.name));
    if (shares_node(spec))
        objections.add("name", "places that are one node, with stiffness = \"auto\", have no force of their own: give "
                               "'stiffness' [N/m] and 'torsional_stiffness' [N m/rad]");
}

void check_joints(const SceneSpec& scene, Objections& objections) {
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
        TableObjections table(objections, fmt::format("joint.{}", j));
        check_name(scene, j, table);
        joint(scene, scene.joints[j], table);
    }
}

} // namespace

void JointTables::check(const SceneSpec& scene, Objections& objections) {
    check_assemblies(scene, objections);
    check_joints(scene, objections);
}

} // namespace skein
