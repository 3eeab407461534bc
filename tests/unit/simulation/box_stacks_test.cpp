// Boxes that meet boxes: a stack comes to rest and bears its weights, a box slides or sticks on one that leans, turns
// on one until friction stops it, two that tumble collide.
#include "loads/gravity.hpp"
#include "scene/make_groups.hpp"
#include "support/meeting.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

using test::gravity;
using test::Meeting;

RodSpec box_at(const std::string& name, const Vec3d& size, const Vec3d& origin) {
    RodSpec spec = test::box_body(size);
    spec.name = name;
    spec.placement.origin = origin;
    spec.placement.normal = Vec3d{1, 0, 0};
    return spec;
}

ContactLaw rubs(double friction, double damping) {
    return {.normal = ContactNormal::linear,
            .stiffness = 1e5,
            .damping = damping,
            .friction = ContactFriction::memory,
            .static_friction = friction,
            .tangential_damping = damping};
}

/// Boxes on a plane that leans by `slope` about y; gravity is turned instead.
SceneSpec on_plane(std::vector<RodSpec> boxes, double slope, const ContactLaw& law, double friction_below) {
    SceneSpec scene;
    scene.rods = std::move(boxes);
    scene.contact = ContactSpec{.law = law};
    Wall wall;
    wall.name = "floor";
    wall.law = law;
    wall.law.static_friction = friction_below;
    scene.walls = {wall};
    scene.loads = {{.load = Gravity{{gravity * std::sin(slope), 0, -gravity * std::cos(slope)}}}};
    scene.time = {.duration = 1, .dt = 1e-5};
    return scene;
}

double mass_of(const Meeting& stage, std::size_t i) { return stage.groups[i].node_mass[0]; }

Vec3d load_on(const Meeting& stage, std::size_t i) {
    return stage.around.loads->load[2 * i].force + stage.around.loads->load[2 * i + 1].force;
}

// Askew on each other, each with its centre above the one below.
TEST(Boxes, OfAStackComeToRestAndBearTheirWeights) {
    RodSpec middle = box_at("middle", {0.08, 0.06, 0.03}, {0.005, -0.002, 0.0552}),
            top = box_at("top", {0.05, 0.05, 0.02}, {0, 0.004, 0.0803});
    middle.placement.normal = Vec3d{1, 0.3, 0};
    top.placement.normal = Vec3d{1, 1, 0};
    SceneSpec scene = on_plane({box_at("bottom", {0.1, 0.08, 0.04}, {0, 0, 0.02}), middle, top}, 0, rubs(0.4, 60), 0.4);
    scene.time.dt = 5e-6;
    Meeting stage(scene);
    stage.advance(120000);
    const double upper = mass_of(stage, 2) * gravity, lower = mass_of(stage, 1) * gravity;
    EXPECT_NEAR(load_on(stage, 2).z, upper, 1e-9 * upper);
    EXPECT_NEAR(load_on(stage, 1).z, lower, 1e-9 * lower) << "the load above is on it";
    EXPECT_NEAR(load_on(stage, 0).z, -upper - lower, 1e-9 * upper);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_LT(std::hypot(load_on(stage, i).x, load_on(stage, i).y), 1e-9 * upper) << i;
        EXPECT_LT(norm(stage.velocity(i)), 1e-10) << i;
        EXPECT_LT(norm(stage.spin(i)), 1e-8) << i;
    }
    const Vec3d before = lane(stage.state(2)[0].position, 0);
    stage.advance(40000);
    EXPECT_LT(norm(lane(stage.state(2)[0].position, 0) - before), 1e-12) << "it creeps";
    EXPECT_EQ(stage.contacts->figures().active, 2);
}

TEST(Boxes, SlideOnABoxThatLeansMoreThanTheirFriction) {
    const double slope = 0.4, time = 0.1;
    for (const double share : {0.9, 1.1}) {
        Meeting stage(on_plane(
            {box_at("below", {0.2, 0.1, 0.02}, {0, 0, 0.01}), box_at("above", {0.06, 0.06, 0.02}, {-0.05, 0, 0.03})},
            slope, rubs(share * std::tan(slope), 30), 2));
        stage.advance(20000);
        const double before = stage.velocity(1).x, free = gravity * std::sin(slope) * time;
        stage.advance(10000);
        const double v = stage.velocity(1).x;
        if (share < 1) EXPECT_NEAR(v - before, (1 - share) * free, 1e-3 * (1 - share) * free);
        else EXPECT_LT(std::abs(v), 1e-6 * free);
        EXPECT_LT(norm(stage.velocity(0)), 1e-5 * free);
        EXPECT_LT(norm(stage.spin(1)), 1e-3);
    }
}

// Four vertices at a distance rho from the axis: J w' = -mu m g rho until it stands.
TEST(Boxes, ThatTurnOnABoxAreStoppedByFriction) {
    const double friction = 0.3, side = 0.06, rate = 8, time = 0.04;
    RodSpec above = box_at("above", {side, side, 0.02}, {0, 0, 0.05});
    above.shape.angular_velocity = {0, 0, rate};
    Meeting stage(on_plane({box_at("below", {0.2, 0.2, 0.04}, {0, 0, 0.02}), above}, 0, rubs(friction, 30), 1));
    stage.advance(4000);
    const double mass = mass_of(stage, 1), rho = std::sqrt(2.0) * (0.5 * side - 0.005);
    const BodyShape& body = *stage.groups[1].body();
    const double inertia = std::max({body.inertia.x, body.inertia.y, body.inertia.z}),
                 slower = friction * mass * gravity * rho / inertia * time;
    EXPECT_NEAR(stage.spin(1).z, rate - slower, 0.01 * slower);
    stage.advance(16000);
    EXPECT_LT(norm(stage.spin(1)), 1e-3 * rate);
    const double stored = stage.contacts->figures().elastic_energy.value();
    EXPECT_GT(stored, 0);
    EXPECT_LT(std::hypot(stage.velocity(1).x, stage.velocity(1).y), 1e-5);
}

/// Two boxes that tumble and meet, elastic; `later`: share of a step by which they do.
SceneSpec collision(ContactNormal normal, double dt, double later) {
    SceneSpec scene;
    RodSpec one = box_at("one", {0.1, 0.08, 0.06}, {0, 0, 0}),
            two = box_at("two", {0.07, 0.09, 0.05}, {0.11 + later * dt, 0.02, 0.03});
    one.shape.angular_velocity = {3, -5, 9};
    two.shape.angular_velocity = {-7, 4, 2};
    two.shape.velocity = {-1, 0.1, -0.2};
    scene.rods = {one, two};
    scene.contact = ContactSpec{.law = {.normal = normal, .stiffness = normal == ContactNormal::hertz ? 1e6 : 1e5}};
    scene.time = {.duration = 1, .dt = dt};
    return scene;
}

/// Change of the energy over that before; momenta stay.
double lost_in(const SceneSpec& scene, std::int64_t steps) {
    Meeting stage(scene);
    const double energy = stage.energy();
    const test::Momenta before = stage.momenta();
    stage.advance(steps);
    EXPECT_TRUE(stage.touched);
    EXPECT_EQ(stage.contacts->figures().active, 0) << "they have parted";
    const test::Momenta after = stage.momenta();
    EXPECT_LT(norm(after.linear - before.linear), 1e-12 * norm(before.linear));
    EXPECT_LT(norm(after.angular - before.angular), 1e-12 * (norm(before.angular) + 0.1 * norm(before.linear)));
    EXPECT_GT(norm(stage.velocity(1) - scene.rods[1].shape.velocity), 0.1) << "they have met";
    return (stage.energy() - energy) / energy;
}

// Where a contact begins within a step changes its error, so the root of the mean square over such places is taken.
TEST(Boxes, ThatCollideKeepMomentaAndEnergy) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz}) {
        double lost[3];
        for (const int i : {0, 1, 2}) {
            const int divide = 1 << 2 * i, places = 12;
            double sum = 0;
            for (int k = 0; k < places; ++k) {
                const double one =
                    lost_in(collision(normal, 4e-5 / divide, static_cast<double>(k) / places), 2000 * divide);
                sum += one * one / places;
            }
            lost[i] = std::sqrt(sum);
        }
        EXPECT_GT(0.25 * std::log2(lost[0] / lost[2]), 1.9) << lost[0] << " " << lost[1] << " " << lost[2];
        EXPECT_LT(lost[2], 1e-6);
    }
}

} // namespace
} // namespace skein
