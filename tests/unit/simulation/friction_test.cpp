// A plane with friction answers all that presses on it: rods upon rods, and walls.
#include "loads/gravity.hpp"
#include "loads/plane_friction.hpp"
#include "loads/uniform_force.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "support/meeting.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {
namespace {

constexpr double rod_radius = 0.02, friction = 0.3, rate = 40;
constexpr std::size_t elements = 6;

/// Along x, its axis at a height above the plane z = 0.
RodSpec lying(const std::string& name, double height) {
    RodSpec spec = test::simple_rod(elements);
    spec.name = name;
    spec.material.youngs_modulus = 1e7;
    spec.section.radius = rod_radius;
    spec.placement.tangent = {1, 0, 0};
    spec.placement.normal = Vec3d{0, 0, 1};
    spec.placement.origin = {0, 0, height};
    return spec;
}

double mass(const RodGroup& group) { return std::accumulate(group.node_mass.begin(), group.node_mass.end(), 0.0); }

/// A rod on the plane, pulled along itself at its steady speed under so much pressure.
constexpr double speed = 1e-4;
SceneSpec pulled(double pressure) {
    PlaneFriction plane;
    plane.stiffness = 500;
    plane.damping = 1;
    plane.tolerance = 5e-3; // so that all of it touches, although it bends a little
    plane.kinetic_forward = plane.kinetic_backward = friction;
    plane.slip_speed = 1e-6;
    SceneSpec scene;
    scene.rods = {lying("lower", rod_radius)};
    scene.rods[0].shape.velocity = {speed, 0, 0};
    const double drag = rate * speed * mass(RodGroup(scene.rods[0], 0, 0, ""));
    // The plane stands first: where a load stands does not matter to what it feels.
    scene.loads = {{.load = plane, .rods = {"lower"}},
                   {.load = Gravity{.acceleration = {0, 0, -test::gravity}}},
                   {.load = UniformForce{.force = {friction * pressure + drag, 0, 0}}, .rods = {"lower"}}};
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = rate}}};
    scene.time = {.duration = 0.3};
    return scene;
}

struct Sliding {
    double friction; ///< N, in the first step
    double lowest;   ///< node after a while, over the radius
};
Sliding slide(const SceneSpec& scene) {
    test::Meeting stage(scene);
    const auto momentum = [&] { return test::momenta(stage.groups[0], stage.state(0)).linear.x; };
    const double before = momentum(), h = stage.plan.dt;
    stage.advance(1);
    const double after = momentum(), pull = scene.loads[2].load.as<UniformForce>().force.x;
    stage.advance(stage.plan.steps - 1);
    double lowest = HUGE_VAL;
    for (const Slot<1>& node : stage.state(0)) lowest = std::min(lowest, lane(node.position, 0).z);
    return {pull - 0.5 * rate * (before + after) - (after - before) / h, lowest / rod_radius};
}

constexpr double stack_stiffness = 2000;
/// The scene with a second rod on the first, pulled along so that it stays where it lies.
SceneSpec stack(double overlap, double pressure) {
    SceneSpec scene = pulled(pressure);
    scene.rods.push_back(lying("upper", 3 * rod_radius - overlap));
    scene.rods[1].shape.velocity = {speed, 0, 0};
    const double drag = rate * speed * mass(RodGroup(scene.rods[1], 0, 0, ""));
    scene.loads.push_back({.load = UniformForce{.force = {drag, 0, 0}}, .rods = {"upper"}});
    scene.contact = ContactSpec{.law = {.normal = ContactNormal::linear, .stiffness = stack_stiffness, .damping = 5}};
    return scene;
}

TEST(PlaneFriction, OfAStackIsThatOfItsWholeWeight) {
    const double alone = test::gravity * mass(RodGroup(lying("lower", rod_radius), 0, 0, "")), weight = 2 * alone;
    // The overlap at which the lower rod carries the upper one, from that of a first guess: the law is linear.
    constexpr double guess = 1e-3;
    test::Meeting first(stack(guess, weight));
    first.advance(1);
    double carried = 0;
    for (std::size_t i = 0; i <= elements; ++i) carried += first.around.loads->load[elements + 1 + i].force.z;
    const double overlap = guess * alone / carried;
    const Sliding s = slide(stack(overlap, weight));
    // Rods whose ends lie abreast are parted along each other at both, or not, by the energy of a contact over an
    // element's length.
    const double parting = 0.5 * stack_stiffness * overlap * overlap * elements;
    EXPECT_NEAR(s.friction, friction * weight, 2.05 * parting);
    EXPECT_LT(parting, 1e-3 * friction * weight);
    EXPECT_GT(s.lowest, 1 - 5e-3) << "the plane carries what lies on the rod too";

    const Sliding by_itself = slide(pulled(alone));
    EXPECT_NEAR(by_itself.friction, friction * alone, 1e-6 * friction * alone);
    EXPECT_GT(by_itself.lowest, 1 - 5e-3);
}

TEST(PlaneFriction, CountsWhatWallsPress) {
    const RodGroup rod(lying("lower", rod_radius), 0, 0, "");
    const double overlap = 1e-3, k = 300, weight = test::gravity * mass(rod);
    const double pressed = weight + 7 * k * overlap; // every node
    SceneSpec scene = pulled(pressed);
    Wall lid;
    lid.name = "lid";
    lid.point = {0, 0, 2 * rod_radius - overlap};
    lid.normal = {0, 0, -1};
    lid.law = {.normal = ContactNormal::linear, .stiffness = k};
    scene.walls = {lid};
    const Sliding s = slide(scene);
    EXPECT_NEAR(s.friction, friction * pressed, 1e-6 * friction * pressed);
}

TEST(PlaneFriction, IsAPassAfterContactsAndWalls) {
    SceneSpec scene = pulled(1);
    scene.contact = ContactSpec{.law = {.normal = ContactNormal::linear, .stiffness = 2000}};
    Wall lid;
    lid.name = "lid";
    lid.law = scene.contact->law;
    scene.walls = {lid};
    const auto groups = make_groups(scene);
    const auto passes = make_plan(scene, groups, {1, 1, 1, 1, {}, Mapping::automatic}).groups[0].program.names();
    const auto place = [&](std::string_view name) {
        return std::find(passes.begin(), passes.end(), name) - passes.begin();
    };
    EXPECT_GT(place("anisotropic_plane"), place("neighbour loads"));
    EXPECT_GT(place("anisotropic_plane"), place("walls"));
    EXPECT_LT(place("anisotropic_plane"), place("kick (damped)"));
}

} // namespace
} // namespace skein
