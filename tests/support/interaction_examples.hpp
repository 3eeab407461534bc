// Small scenes in which something touches: every interaction, every kind of wall and of body, rods that cross and that
// lie side by side. Tests of all interactions run over this list. A kind that is new has no example, and the list does
// not compile.
#pragma once

#include "physics/tables.hpp"
#include "support/load_examples.hpp"
#include "support/meeting.hpp"

#include <functional>
#include <string>
#include <vector>

namespace skein::test {

/// A scene whose contacts have the law, turned and shifted. What flies touches within 5 ms and has parted after 40 ms.
struct InteractionExample {
    std::string name;
    std::function<SceneSpec(const ContactLaw&, const Turn&)> scene;
    bool has_walls = false; ///< which take momentum
    bool can_turn = true;   ///< else it can only be shifted
    double lost = 2e-6;     ///< of the energy, at most, where nothing takes any
};

static_assert(
    PhysicsTables::count == 11,
    "contact and walls have examples here; loads, joints, the fluid, relaxation, implicit steps, the audit, probes, "
    "expected values and rotary inertia have tests of their own: a new physics needs examples");
static_assert(std::size(wall_names) == 4, "a new kind of wall needs an example");

/// Half a metre long, its middle at `middle`, in motion.
inline RodSpec flying_stick(const std::string& name, const Vec3d& middle, const Vec3d& tangent, const Vec3d& velocity) {
    RodSpec rod = simple_rod(8);
    rod.name = name;
    rod.material.youngs_modulus = 1e7;
    rod.shape.length = 0.5;
    rod.shape.velocity = velocity;
    rod.placement.tangent = (1 / norm(tangent)) * tangent;
    rod.placement.normal = Vec3d{0, 0, 1};
    rod.placement.origin = middle - 0.25 * rod.placement.tangent;
    return rod;
}

inline SceneSpec of_rods(std::vector<RodSpec> rods, const Turn& turn) {
    SceneSpec scene;
    for (const RodSpec& rod : rods) scene.rods.push_back(turn.rod(rod));
    scene.time = {.duration = 1, .dt = 1e-5};
    return scene;
}

/// A rod flies down upon whatever stands in its way, a little askew.
inline SceneSpec upon(const RodSpec& other, const ContactLaw& law, const Turn& turn) {
    SceneSpec scene =
        of_rods({flying_stick("flying", {0.03, 0, 0.0425}, {1, 0.02, 0.01}, {0.1, 0.05, -1}), other}, turn);
    scene.contact = ContactSpec{.law = law};
    return scene;
}

/// A body flies down upon a rod.
inline SceneSpec upon_rod(RodSpec body, double height, const ContactLaw& law, const Turn& turn) {
    body.placement.origin = {0.02, 0, height};
    body.placement.normal = Vec3d{1, 0, 0};
    body.shape.velocity = {0.1, 0.05, -1};
    SceneSpec scene = of_rods({flying_stick("rod", {0, 0, 0}, {1, 0.1, 0}, {0, 0, 0}), body}, turn);
    scene.contact = ContactSpec{.law = law};
    return scene;
}

/// A box flies down upon another one, a little askew, so that faces meet.
inline SceneSpec two_boxes(const ContactLaw& law, const Turn& turn) {
    RodSpec below = box_body({0.1, 0.06, 0.04}), above = box_body({0.05, 0.08, 0.03});
    below.name = "below";
    above.name = "above";
    below.placement.normal = above.placement.normal = Vec3d{1, 0.2, 0};
    above.placement.origin = {0.01, 0.005, 0.0375};
    above.placement.tangent = {0.03, 0.05, 1};
    above.shape.velocity = {0.1, 0.05, -1};
    SceneSpec scene = of_rods({below, above}, turn);
    scene.contact = ContactSpec{.law = law};
    return scene;
}

/// A rod flies down, askew, at a wall.
inline SceneSpec at_wall(Wall wall, const ContactLaw& law, const Turn& turn) {
    SceneSpec scene = of_rods({flying_stick("flying", {0, 0, 0.06}, {1, 0.1, 0.1}, {0.1, 0.3, -1})}, turn);
    wall.name = "wall";
    wall.law = law;
    if (wall.kind == WallKind::box) {
        wall.lower += turn.shift;
        wall.upper += turn.shift;
    }
    wall.point = turn.point(wall.point);
    wall.normal = turn.direction(wall.normal);
    wall.axis = turn.direction(wall.axis);
    scene.walls = {wall};
    return scene;
}

inline std::vector<InteractionExample> interaction_examples() {
    std::vector<InteractionExample> all;
    const auto add_pair = [&](const std::string& name, double lost, const RodSpec& other) {
        all.push_back({.name = name,
                       .scene = [=](const ContactLaw& law, const Turn& turn) { return upon(other, law, turn); },
                       .lost = lost});
    };
    const Vec3d still{0, 0, 0};
    // Neighbours hand contacts over as if both saw the same energy, which elements that are bent against each other do
    // not.
    add_pair("rods that cross", 1e-4, flying_stick("other", {0, 0, 0}, {0.3, 1, 0}, still));
    add_pair("rods side by side", 3e-3, flying_stick("other", {0, 0, 0}, {1, 0.03, 0}, still));
    add_pair("a rod on a crooked one", 2e-4, [&] {
        RodSpec rod = flying_stick("other", {0, 0, -0.02}, {0.3, 1, 0}, still);
        rod.shape.start_curvature = Vec3d{0.4, 0.2, 0.4};
        return rod;
    }());
    const auto add_body = [&](const std::string& name, const RodSpec& body, double height) {
        all.push_back({.name = name, .scene = [=](const ContactLaw& law, const Turn& turn) {
                           return upon_rod(body, height, law, turn);
                       }});
    };
    add_body("a ball", rigid_body(0, 0.03), 0.0525);
    add_body("a capsule", rigid_body(0.1, 0.015), 0.0375);
    add_body("a body of three parts", crooked_body(), 0.07);
    add_body("a box", box_body({0.1, 0.06, 0.04}), 0.0525);
    all.push_back({.name = "two boxes",
                   .scene = [](const ContactLaw& law, const Turn& turn) { return two_boxes(law, turn); },
                   .lost = 1e-5});
    const auto add_wall = [&](const std::string& name, const Wall& wall) {
        all.push_back({.name = name,
                       .scene = [=](const ContactLaw& law, const Turn& turn) { return at_wall(wall, law, turn); },
                       .has_walls = true,
                       .can_turn = wall.kind != WallKind::box});
    };
    add_wall("a plane", {.kind = WallKind::plane, .point = {0, 0, 0.01}});
    add_wall("a tube", {.kind = WallKind::tube, .point = {0, 0, 0.31}, .axis = {1, 0, 0}, .radius = 0.3});
    add_wall(
        "round a tube",
        {.kind = WallKind::tube, .point = {0, 0, -0.19}, .axis = {1, 0, 0}, .radius = 0.2, .side = WallSide::outside});
    add_wall("a ball of a wall", {.kind = WallKind::ball, .point = {0, 0, 0.36}, .radius = 0.45});
    add_wall("round a ball",
             {.kind = WallKind::ball, .point = {0, 0, -0.165}, .radius = 0.2, .side = WallSide::outside});
    add_wall("a box of walls", {.kind = WallKind::box, .lower = {-1, -1, 0.01}, .upper = {1, 1, 1}});
    return all;
}

} // namespace skein::test
