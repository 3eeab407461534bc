// A joint of every kind between two rods, or a rod and a body, that fly and turn.
#pragma once

#include "physics/joints/joint_interaction.hpp"
#include "support/scenes_for_tests.hpp"

#include <string>
#include <vector>

namespace skein::test {

inline RodSpec stick(const std::string& name, const Vec3d& origin, const Vec3d& tangent) {
    RodSpec rod = simple_rod(8);
    rod.name = name;
    rod.material.youngs_modulus = 1e7;
    rod.shape.length = 0.8;
    rod.section.radius = 0.02;
    rod.placement.origin = origin;
    rod.placement.tangent = tangent;
    return rod;
}

struct JointExample {
    std::string name;
    SceneSpec scene;
};

static_assert(std::size(joint_names) == 9, "a new kind of joint needs an example");

/// Two rods, or a rod and a body, that fly and turn, joined in every way.
inline std::vector<JointExample> joint_examples(double stiffness = 1e4, double damping = 0) {
    std::vector<JointExample> all;
    const auto add = [&](const std::string& name, RodSpec first, RodSpec second, JointSpec joint) {
        SceneSpec scene;
        first.shape.velocity = {0.3, -0.2, 0.5};
        first.shape.angular_velocity = {0.4, 2, -1};
        scene.rods = {first, second};
        joint.between = {first.name, second.name};
        joint.law.stiffness = stiffness;
        joint.law.damping = damping;
        scene.joints = {joint};
        scene.time.duration = 1;
        all.push_back({name, scene});
    };
    const RodSpec along = stick("along", {0, 0, 0}, {1, 0, 0}), on = stick("on", {0.8, 0, 0}, {0.6, 0.8, 0}),
                  beside = stick("beside", {0.1, 0.04, 0}, {1, 0, 0}), up = stick("up", {0.45, 0, 0.02}, {0, 0, 1});
    const double turning = stiffness * 1e-2;
    add("spherical", along, on, {.kind = JointKind::spherical});
    add("spherical, in the middle", along, stick("on", {0.3, 0, 0.1}, {0, 1, 0}),
        {.kind = JointKind::spherical, .at = {0.4, 0.3}});
    add("hinge", along, on,
        {.kind = JointKind::hinge,
         .axis = {0, 0, 1},
         .law = {.torsional_stiffness = turning, .torsional_damping = 0.01 * damping}});
    add("fixed", along, on,
        {.kind = JointKind::fixed, .law = {.torsional_stiffness = turning, .torsional_damping = 0.01 * damping}});
    add("side by side", along, beside, {.kind = JointKind::side_by_side, .law = {.repulsion = 20 * stiffness}});
    add("tip to side", up, along,
        {.kind = JointKind::tip_to_side,
         .at = {0, 0},
         .law = {.torsional_stiffness = turning, .repulsion = stiffness}});
    add("universal", along, on,
        {.kind = JointKind::universal,
         .axis = {0, 0, 1},
         .second_axis = {0, 1, 0},
         .law = {.torsional_stiffness = turning, .torsional_damping = 0.01 * damping}});
    add("slider with a spring", along, on,
        {.kind = JointKind::slider,
         .axis = {0.6, 0, 0.8},
         .law = {.torsional_stiffness = turning, .torsional_damping = 0.01 * damping},
         .axis_law = {.spring = 0.1 * stiffness, .damping = 0.1 * damping}});
    add("hinge with a spring and stops", along, on,
        {.kind = JointKind::hinge,
         .axis = {0, 0, 1},
         .law = {.torsional_stiffness = turning, .torsional_damping = 0.01 * damping},
         .axis_law = {.spring = 0.1 * turning,
                      .damping = 0.001 * damping,
                      .limits = {-0.05, 0.05},
                      .stop_stiffness = 0.1 * turning}});
    add("universal with springs and a stop", along, on,
        {.kind = JointKind::universal,
         .axis = {0, 0, 1},
         .second_axis = {0, 1, 0},
         .law = {.torsional_stiffness = turning, .torsional_damping = 0.01 * damping},
         .axis_law = {.spring = 0.1 * turning, .damping = 0.001 * damping},
         .about_second = {.spring = 0.05 * turning, .limits = {-0.05, 0.05}, .stop_stiffness = 0.1 * turning}});
    add("spherical with a spring, a cone and a twist", along, on,
        {.kind = JointKind::spherical,
         .axis = {0.6, 0, 0.8},
         .law = {.cone = 0.05},
         .axis_law = {.spring = 0.1 * turning,
                      .damping = 0.001 * damping,
                      .limits = {-0.03, 0.04},
                      .stop_stiffness = 0.1 * turning}});
    add("distance", along, stick("on", {0.3, 0, 0.1}, {0, 1, 0}), {.kind = JointKind::distance, .at = {0.4, 0.3}});
    add("bushing", along, on,
        {.kind = JointKind::bushing,
         .law = {.torsional_stiffness = turning,
                 .torsional_damping = 0.01 * damping,
                 .along = {1, 0.3, 0.6},
                 .about = {0.2, 1, 0.5}}});
    RodSpec ball = rigid_body(0, 0.1);
    ball.name = "ball";
    ball.placement.origin = {0.9, 0, 0};
    add("a body, fixed", along, ball, {.kind = JointKind::fixed, .law = {.torsional_stiffness = turning}});
    return all;
}

/// Rods, an inner node and a body that fly and turn, with fixed joints by common nodes.
inline std::vector<JointExample> common_node_examples() {
    std::vector<JointExample> all;
    const auto add = [&](const std::string& name, std::vector<RodSpec> rods, std::vector<JointSpec> joints) {
        SceneSpec scene;
        rods[0].shape.velocity = {0.3, -0.2, 0.5};
        rods[0].shape.angular_velocity = {0.4, 2, -1};
        for (JointSpec& joint : joints) joint.kind = JointKind::fixed;
        scene.rods = std::move(rods);
        scene.joints = std::move(joints);
        scene.time.duration = 1;
        all.push_back({name, scene});
    };
    const RodSpec along = stick("along", {0, 0, 0}, {1, 0, 0}), on = stick("on", {0.8, 0, 0}, {0.6, 0.8, 0}),
                  third = stick("third", {0.8, 0, 0}, {0, 0.6, 0.8}),
                  straight = stick("straight", {0.8, 0, 0}, {1, 0, 0}), up = stick("up", {0.4, 0, 0}, {0, 0, 1});
    RodSpec thin = straight, linear = on, neo = straight, rubber = along;
    thin.section.radius = 0.012;
    linear.material.law = Law::linear;
    neo.material.law = rubber.material.law = Law::neo_hookean;
    add("in line", {along, straight}, {{.between = {"along", "straight"}}});
    add("thick and thin", {along, thin}, {{.between = {"along", "straight"}}});
    add("neo-Hookean", {rubber, neo}, {{.between = {"along", "straight"}}});
    add("at an angle, of two laws", {along, linear}, {{.between = {"along", "on"}}});
    add("three in a place", {along, on, third},
        {{.between = {"along", "on"}}, {.between = {"third", "on"}, .at = {0, 0}}});
    add("an inner node", {along, up}, {{.between = {"along", "up"}, .at = {0.5, 0}}});
    RodSpec ball = rigid_body(0, 0.1);
    ball.name = "ball";
    ball.placement.origin = {0.9, 0, 0};
    add("a body", {along, ball}, {{.between = {"along", "ball"}}});
    RodSpec leg = stick("leg", {0.9, 0.1, 0}, {0, 1, 0});
    add("two rods on a body", {along, ball, leg},
        {{.between = {"along", "ball"}}, {.between = {"leg", "ball"}, .at = {0, 0}}});
    return all;
}

} // namespace skein::test
