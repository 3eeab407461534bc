#include "physics/joints/assembly_check.hpp"

#include "core/nearest.hpp"
#include "joints/junction.hpp"
#include "physics/group_names.hpp"
#include "physics/rods/placement_check.hpp"
#include "physics/scene_spec.hpp"
#include "physics/table_objections.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace skein {

namespace {

int number_of(const SceneSpec& scene, const std::string& assembly) {
    for (std::size_t a = 0; a < scene.assemblies.size(); ++a)
        if (scene.assemblies[a].name == assembly) return static_cast<int>(a);
    return -1;
}

/// Keys that have no use in the copies of an assembly.
void member(const SceneSpec& scene, const RodSpec& rods, Objections& objections) {
    std::vector<std::string_view> names;
    for (const AssemblySpec& assembly : scene.assemblies) names.push_back(assembly.name);
    if (number_of(scene, rods.assembly) < 0)
        return objections.add("assembly",
                              fmt::format("there is no assembly '{}'{}", rods.assembly,
                                          names.empty() ? "" : suggestion(rods.assembly, names, "the assemblies are")));
    const PlacementKind kind = rods.placement.kind;
    if (kind == PlacementKind::packing || kind == PlacementKind::file)
        objections.add("placement.kind", fmt::format("a placement of kind \"{}\" is not for rods of an assembly",
                                                     nth(placement_names, kind)));
    if (rods.ends_move() || rods.start != EndKind::free || rods.end != EndKind::free || rods.hold.any())
        objections.add(
            "",
            "the ends of rods in an [[assembly]] are free: what holds them would have to go along with the copy. Plain "
            "groups with joints may be held: leave 'assembly' out of [[rods]], and without copies leave [[assembly]] "
            "out");
}

void joint(const SceneSpec& scene, const JointSpec& spec, Objections& objections) {
    const JointKind kind = spec.kind;
    const std::string where = fmt::format("for a joint of kind \"{}\"", nth(joint_names, kind));
    if (spec.between.size() != 2) return objections.add("between", "'between' names two groups, or twice the same");
    std::vector<const RodSpec*> groups;
    for (std::size_t i = 0; i < 2; ++i)
        groups.push_back(group_named(scene, spec.between[i], objections, fmt::format("between.{}", i)));
    if (!groups[0] || !groups[1]) return;
    if (groups[0]->assembly != groups[1]->assembly)
        objections.add("between",
                       fmt::format("'{}' and '{}' belong to different assemblies: joints are between rods of one copy",
                                   spec.between[0], spec.between[1]));
    const bool points = kind == JointKind::spherical || kind == JointKind::hinge || kind == JointKind::fixed;
    if (!points) objections.unused({"pairs", "first", "second"}, where);
    else if (spec.pairs != JointPairs::listed) objections.unused({"first", "second"}, "without pairs = \"listed\"");
    else if (spec.first.empty() || spec.first.size() != spec.second.size())
        objections.add("", fmt::format("'first' and 'second' list as many rods each, at least one: they have {} and {}",
                                       spec.first.size(), spec.second.size()));
    if (spec.at.size() != 2) objections.add("at", "'at' needs two values, a place on each of both");
    else if (kind == JointKind::tip_to_side && spec.at[0] != 0 && spec.at[0] != 1)
        objections.add("at", "the tip is at the start or the end of the first rod: at[0] is 0 or 1");
    if (kind == JointKind::side_by_side) objections.unused({"at", "torsional_stiffness", "torsional_damping"}, where);
    if (kind == JointKind::spherical) objections.unused({"torsional_stiffness", "torsional_damping"}, where);
    if (kind != JointKind::hinge) objections.unused({"axis"}, where);
    else if (zero(spec.axis)) objections.add("axis", "a hinge needs 'axis', a direction");
    if (kind != JointKind::side_by_side && kind != JointKind::tip_to_side)
        objections.unused({"repulsion", "gap"}, where);
    const bool common_node = shares_node(spec);
    if (kind != JointKind::fixed && spec.law.stiffness == 0)
        objections.add("", fmt::format("'stiffness' [N/m] is needed by number {}", where));
    if (common_node) objections.unused({"damping"}, "of two places that are one node, with stiffness = \"auto\"");
    if ((kind == JointKind::fixed || kind == JointKind::hinge) && spec.law.torsional_stiffness == 0 && !common_node)
        objections.add(
            "", fmt::format("'torsional_stiffness' [N m/rad] is needed {}{}", where,
                            kind == JointKind::fixed ? " whose 'stiffness' is a number; both may be left out" : ""));
    if (common_node && FluidTables::has_immersed(scene) && scene.immersion.coupling == RodCoupling::two_way)
        objections.add("stiffness", "rods that feel the fluid have no common nodes yet: give 'stiffness' [N/m] and "
                                    "'torsional_stiffness' [N m/rad]");
    if (common_node && scene.time.integrator != Integrator::verlet && (groups[0]->body || groups[1]->body))
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

void check_joints(const SceneSpec& scene, Objections& objections) {
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
        TableObjections table(objections, fmt::format("joint.{}", j));
        joint(scene, scene.joints[j], table);
    }
    if (scene.joints.empty()) return;
    if (scene.time.relax) objections.add("joint.0", "time.relax is not for rods that are joined yet");
}

} // namespace

void JointTables::check(const SceneSpec& scene, Objections& objections) {
    check_assemblies(scene, objections);
    check_joints(scene, objections);
}

std::vector<int> assembly_of_groups(const SceneSpec& scene) {
    std::vector<int> assembly;
    for (const RodSpec& rods : scene.rods) assembly.push_back(number_of(scene, rods.assembly));
    // Groups of no assembly that joints connect, by one or more, are one.
    const auto find = [&](const std::string& name) {
        for (std::size_t g = 0; g < scene.rods.size(); ++g)
            if (scene.rods[g].name == name) return g;
        return scene.rods.size();
    };
    int next = static_cast<int>(scene.assemblies.size());
    for (const JointSpec& joint : scene.joints) {
        if (joint.between.size() != 2) continue;
        const std::size_t a = find(joint.between[0]), b = find(joint.between[1]);
        if (a == scene.rods.size() || b == scene.rods.size()) continue;
        const int of_a = assembly[a], of_b = assembly[b];
        if (of_a < 0 && of_b < 0) assembly[a] = assembly[b] = next++;
        else if (of_a < 0) assembly[a] = of_b;
        else if (of_b < 0) assembly[b] = of_a;
        else std::replace(assembly.begin(), assembly.end(), std::max(of_a, of_b), std::min(of_a, of_b));
    }
    // Numbers without gaps.
    std::vector<int> used;
    for (int& number : assembly) {
        if (number < static_cast<int>(scene.assemblies.size())) continue;
        const auto at = std::find(used.begin(), used.end(), number);
        const int place = static_cast<int>(scene.assemblies.size()) + static_cast<int>(at - used.begin());
        if (at == used.end()) used.push_back(number);
        number = place;
    }
    return assembly;
}

std::string assembly_name(const SceneSpec& scene, int assembly) {
    if (assembly < static_cast<int>(scene.assemblies.size())) return nth(scene.assemblies, assembly).name;
    std::string name;
    const std::vector<int> of_group = assembly_of_groups(scene);
    for (std::size_t g = 0; g < of_group.size(); ++g)
        if (of_group[g] == assembly) name += (name.empty() ? "" : " + ") + scene.rods[g].name;
    return name;
}

} // namespace skein
