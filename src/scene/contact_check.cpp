#include "scene/contact_check.hpp"

#include "core/nearest.hpp"
#include "physics/group_names.hpp"
#include "physics/scene_spec.hpp"
#include "physics/table_objections.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace skein {

namespace {

/// `assumed`: the overlap that the time step allows for, over the diameter.
void law(const ContactLaw& law, double assumed, Objections& objections) {
    if (law.stiffness == 0 && law.restitution <= 0)
        objections.add("", "it needs 'stiffness', a number or \"auto\", or 'restitution' and 'collision_time' [s]");
    if (law.stiffness_is_automatic() && law.restitution > 0)
        objections.add("stiffness", "'stiffness' = \"auto\" has no use beside 'restitution', which chooses it");
    if (!law.stiffness_is_automatic()) objections.unused({"accepted_overlap"}, "without stiffness = \"auto\"");
    else if (law.accepted_overlap > assumed)
        objections.add(objections.given("accepted_overlap") ? "accepted_overlap" : "stiffness",
                       fmt::format("an accepted overlap of {:g} is more than the {:g} that the time step allows for",
                                   law.accepted_overlap, assumed));
    if (law.restitution <= 0) {
        objections.unused({"collision_time", "collision_speed"}, "without 'restitution'");
    } else {
        if (law.collision_time <= 0) objections.add("", "'restitution' needs 'collision_time' [s]");
        if (law.normal == ContactNormal::linear) objections.unused({"collision_speed"}, "for the linear law");
        else if (law.collision_speed <= 0)
            objections.add("", "'restitution' of the hertz law needs 'collision_speed' [m/s]");
    }
    if (law.friction == ContactFriction::none)
        objections.unused({"static_friction", "kinetic_friction", "friction_from"}, "without 'friction'");
    else if (law.static_friction <= 0 && law.kinetic_friction <= 0)
        objections.add("", "friction needs 'static_friction' or 'kinetic_friction'");
    if (slips_always(law.friction) && law.slip_speed <= 0) objections.add("", "this friction needs 'slip_speed' [m/s]");
    if (law.friction != ContactFriction::anisotropic)
        objections.unused({"kinetic_backward", "kinetic_sideways"}, "without friction = \"anisotropic\"");
    else if (law.kinetic_friction <= 0)
        objections.add("", "anisotropic friction needs 'kinetic_friction', of motion along the tangent, above 0");
    if (law.soft_until == 0) objections.unused({"soft_stiffness", "soft_damping"}, "without 'soft_until' [s]");
}

/// A wall or a side of a box.
void watched(const SceneSpec& scene, const std::string& name, Objections& objections) {
    std::vector<std::string> names;
    for (const Wall& wall : scene.walls) {
        if (wall.kind != WallKind::box) names.push_back(wall.name);
        else
            for (const std::string_view side : box_side_names)
                if (has_side(wall, side)) names.push_back(fmt::format("{} {}", wall.name, side));
    }
    if (std::find(names.begin(), names.end(), name) != names.end()) return;
    const std::vector<std::string_view> known(names.begin(), names.end());
    objections.add("servo.watch",
                   fmt::format("there is no wall '{}' to watch{}", name, suggestion(name, known, "the walls are")));
}

void contact_pair(const SceneSpec& scene, const ContactPair& pair, Objections& objections) {
    if (pair.between.size() != 2) objections.add("between", "'between' names two groups, or one group twice");
    for (std::size_t i = 0; i < pair.between.size(); ++i)
        group_named(scene, pair.between[i], objections, fmt::format("between.{}", i));
    law(pair.law, scene.contact->overlap, objections);
    if (pair.law.normal != scene.contact->law.normal || pair.law.friction != scene.contact->law.friction)
        objections.add("", "'normal' and 'friction' must be those of [contact]; the numbers may differ");
}

} // namespace

void check_contact(const SceneSpec& scene, Objections& objections) {
    if (!scene.contact) {
        for (std::size_t i = 0; i < scene.contact_pairs.size(); ++i)
            objections.add(fmt::format("contact_pair.{}", i), "a [[contact_pair]] needs [contact]");
        return;
    }
    TableObjections contact(objections, "contact");
    law(scene.contact->law, scene.contact->overlap, contact);
    if (scene.contact->law.friction == ContactFriction::anisotropic)
        contact.add("friction", "anisotropic friction is for walls");
    if (!scene.contact->self) contact.unused({"self_gap"}, "without 'self'");
    if (scene.time.integrator != Integrator::verlet)
        contact.add("", "contact needs integrator = \"verlet\": the kicks of \"pefrl\" go backwards too");
    for (std::size_t i = 0; i < scene.contact_pairs.size(); ++i) {
        TableObjections pair(objections, fmt::format("contact_pair.{}", i));
        contact_pair(scene, scene.contact_pairs[i], pair);
    }
}

void check_walls(const SceneSpec& scene, Objections& objections) {
    for (std::size_t i = 0; i < scene.walls.size(); ++i) {
        const Wall& wall = scene.walls[i];
        TableObjections table(objections, fmt::format("wall.{}", i));
        if (!good_name(wall.name))
            table.add("name", fmt::format("'{}' cannot name a wall: use letters, digits, _ and -", wall.name));
        for (std::size_t j = 0; j < i; ++j)
            if (scene.walls[j].name == wall.name) table.add("name", fmt::format("two walls are named '{}'", wall.name));
        acted_on(scene, wall.rods, table);
        law(wall.law, ContactSpec{}.overlap, table);
        if (wall.servo.drives()) watched(scene, wall.servo.watch, table);
    }
    if (!scene.walls.empty() && scene.time.integrator != Integrator::verlet)
        objections.add("wall.0", "walls need integrator = \"verlet\"");
}

} // namespace skein
