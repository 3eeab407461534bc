// Rigid bodies among walls, rods and each other: they roll, slip, bounce and collide; what scenes may not say of them.
#include "contact/contact_limits.hpp"
#include "diagnostics/observables.hpp"
#include "loads/end_force.hpp"
#include "loads/gravity.hpp"
#include "loads/plane_friction.hpp"
#include "loads/slender_body_drag.hpp"
#include "loads/uniform_couple.hpp"
#include "loads/uniform_force.hpp"
#include "rod/rigid.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"
#include "support/meeting.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

using test::Meeting;

constexpr double radius = 0.02, gravity = 9.81;

/// Of a ball its centre stands at `origin`.
RodSpec ball(const std::string& name, Vec3d origin, Vec3d velocity, double r = radius) {
    RodSpec spec = test::rigid_body(0, r);
    spec.name = name;
    spec.placement.origin = origin;
    spec.shape.velocity = velocity;
    return spec;
}

Wall floor_of(const ContactLaw& law) {
    Wall wall;
    wall.name = "floor";
    wall.law = law;
    return wall;
}

/// A ball on a plane, seen along the plane: gravity leans.
Meeting rolling(double slope, double friction) {
    SceneSpec scene;
    const double k = 1e5, mass = 1000 * 4.0 / 3 * M_PI * radius * radius * radius,
                 overlap = 0.5 * mass * gravity * std::cos(slope) / k;
    scene.rods = {ball("ball", {0, 0, radius - overlap}, {0, 0, 0})};
    scene.walls = {floor_of({.normal = ContactNormal::linear,
                             .stiffness = k,
                             .damping = 20,
                             .friction = ContactFriction::memory,
                             .static_friction = friction,
                             .tangential_damping = 10})};
    scene.loads = {{.load = Gravity{{gravity * std::sin(slope), 0, -gravity * std::cos(slope)}}}};
    scene.time = {.duration = 1, .dt = 5e-5};
    return Meeting(scene);
}

TEST(RigidBall, RollsDownAnIncline) {
    const double slope = 0.4, time = 0.5;
    Meeting stage = rolling(slope, 0.3);
    stage.advance(10000);
    const double v = 5.0 / 7 * gravity * std::sin(slope) * time;
    EXPECT_NEAR(stage.velocity(0).x, v, 1e-3 * v);
    EXPECT_NEAR(stage.spin(0).y * radius, v, 1e-3 * v);
    EXPECT_NEAR(lane(rigid_centre(stage.state(0).data()).position, 0).x, 0.5 * v * time, 1e-3 * v * time);
}

TEST(RigidBall, SlipsWhereFrictionIsTooWeak) {
    const double slope = 0.4, limit = 2.0 / 7 * std::tan(slope), time = 0.5;
    for (const double share : {0.97, 1.03}) {
        Meeting stage = rolling(slope, share * limit);
        stage.advance(10000);
        const bool slips = share < 1;
        const double mu = slips ? share * limit : limit;
        const double v = gravity * (std::sin(slope) - mu * std::cos(slope)) * time,
                     rim = 2.5 * mu * gravity * std::cos(slope) * time;
        EXPECT_NEAR(stage.velocity(0).x, v, 1e-3 * v) << share;
        EXPECT_NEAR(stage.spin(0).y * radius, rim, 1e-3 * rim) << share;
    }
}

TEST(RigidBall, BouncesWithTheRestitutionOfTheWall) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (const double restitution : {1.0, 0.7}) {
            SceneSpec scene;
            scene.rods = {ball("ball", {0, 0, 1.1 * radius}, {0.3, 0, -1})};
            scene.walls = {floor_of({.normal = normal, .restitution = restitution, .collision_time = 2e-3, .collision_speed = 1})};
            scene.time = {.duration = 1, .dt = 2e-6};
            Meeting stage(scene);
            const double before = stage.energy();
            stage.advance(3000);
            EXPECT_NEAR(stage.velocity(0).z, restitution, 2e-3);
            EXPECT_NEAR(stage.velocity(0).x, 0.3, 1e-12);
            if (restitution == 1) {
                EXPECT_NEAR(stage.energy(), before, 1e-5 * before);
            }
        }
}

TEST(RigidBall, CollidesWithAnother) {
    const double restitution = 0.8, big = 1.5 * radius;
    SceneSpec scene;
    scene.rods = {ball("one", {0, 0, 0}, {1, 0.2, 0}), ball("two", {radius + 1.1 * big, 0, 0}, {-0.5, 0.2, 0}, big)};
    scene.contact = ContactSpec{.law = {.normal = ContactNormal::linear, .restitution = restitution, .collision_time = 1e-3}};
    scene.time = {.duration = 1, .dt = 1e-6};
    Meeting stage(scene);
    const test::Momenta before = stage.momenta();
    const double size = norm(before.linear);
    stage.advance(5000);
    EXPECT_TRUE(stage.touched);
    const test::Momenta after = stage.momenta();
    EXPECT_LT(norm(after.linear - before.linear), 1e-12 * size);
    EXPECT_LT(norm(after.angular - before.angular), 1e-12 * size * radius);
    EXPECT_NEAR(stage.velocity(1).x - stage.velocity(0).x, 1.5 * restitution, 2e-3);
    EXPECT_NEAR(stage.velocity(0).y, 0.2, 1e-9);
}

/// A capsule that spins flies into a rod, and rubs.
SceneSpec crash() {
    SceneSpec scene;
    RodSpec rod = test::simple_rod(10);
    rod.shape.length = 0.5;
    rod.placement.origin = {0, 0, -0.25};
    RodSpec capsule = test::rigid_body(0.1, 0.015);
    capsule.placement.origin = {0.06, -0.03, 0.07};
    capsule.placement.tangent = {0.2, 1, 0.4};
    capsule.shape.velocity = {-2, 0, 0.5};
    capsule.shape.angular_velocity = {5, -3, 40};
    scene.rods = {rod, capsule};
    scene.contact = ContactSpec{.law = {.normal = ContactNormal::hertz,
                                        .stiffness = 1e6,
                                        .damping = 100,
                                        .friction = ContactFriction::memory,
                                        .static_friction = 0.4}};
    scene.time = {.duration = 1, .dt = 1e-5};
    return scene;
}

TEST(RigidBody, KeepsMomentaAsItHitsARod) {
    Meeting stage(crash());
    const test::Momenta before = stage.momenta();
    stage.advance(5000);
    EXPECT_TRUE(stage.touched);
    const test::Momenta after = stage.momenta();
    EXPECT_LT(norm(after.linear - before.linear), 1e-12 * norm(before.linear));
    EXPECT_LT(norm(after.angular - before.angular), 1e-12 * norm(before.angular));
    EXPECT_GT(norm(stage.velocity(1) - Vec3d{-2, 0, 0.5}), 0.1) << "has hit";
}

/// Balls and capsules packed over a floor, with rods among them.
SceneSpec heap() {
    SceneSpec scene;
    RodSpec rods = test::simple_rod(6), balls = test::rigid_body(0, 0.03), capsules = test::rigid_body(0.08, 0.015);
    rods.name = "rods", balls.name = "balls", capsules.name = "capsules";
    rods.shape.length = 0.3;
    rods.material.youngs_modulus = 1e7;
    long seed = 0;
    for (RodSpec* spec : {&rods, &balls, &capsules}) {
        spec->placement.kind = PlacementKind::packing;
        spec->placement.packing = {.count = 9 + 2 * seed, .seed = seed + 1, .upper = {0.5, 0.5, 0.35}};
        ++seed;
    }
    scene.rods = {balls, rods, capsules};
    const ContactLaw law{.normal = ContactNormal::hertz,
                         .stiffness = 1e6,
                         .damping = 100,
                         .friction = ContactFriction::memory,
                         .static_friction = 0.4};
    scene.contact = ContactSpec{.law = law};
    scene.walls = {floor_of(law)};
    scene.loads = {{.load = Gravity{}}};
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 1}},
                     {.damping = {.kind = DampingKind::physical, .translational = 0.01, .rotational = 1e-6}, .rods = {"capsules"}}};
    scene.time = {.duration = 1, .dt = 4e-5};
    return scene;
}

TEST(RigidBody, HasTheSameBitsAtEveryWidth) {
    std::uint64_t one = 0;
    for (const int lanes : {1, 2, 4, 8})
        for (const int threads : {1, 2}) {
            Meeting stage(heap(), lanes, threads);
            stage.advance(3000);
            EXPECT_TRUE(stage.touched);
            if (one == 0) one = stage.rods->digest();
            EXPECT_EQ(stage.rods->digest(), one) << lanes << " lanes, " << threads << " threads";
        }
}

// Against every point of the surface and every direction that may be pushed there, sampled.
TEST(RigidBody, YieldsNowhereMoreThanItsContactLimitSays) {
    for (const double length : {0.0, 0.02, 0.1, 1.0}) {
        const RodGroup group(test::rigid_body(length, radius), 0, 0, "");
        const ContactMobility found = contact_mobility(group);
        const double l = group.element[0].rest_length, m = element_mass(group);
        const Vec3d inverse = group.element[0].inv_inertia;
        double tangential = 0;
        for (int i = 0; i <= 2000; ++i) {
            const double angle = 0.5 * M_PI * i / 2000; // on a round end, whose rim is the cylinder's end
            const Vec3d normal{std::cos(angle), 0, std::sin(angle)}, arm = Vec3d{0, 0, 0.5 * l} + radius * normal;
            for (const Vec3d& t : {Vec3d{0, 1, 0}, Vec3d{-normal.z, 0, normal.x}}) {
                const Vec3d turn = cross(arm, t);
                tangential = std::max(tangential, 1 / m + dot(turn, scale(inverse, turn)));
            }
        }
        EXPECT_NEAR(found.tangential, tangential, 1e-6 * tangential) << length;
        EXPECT_NEAR(found.normal, 1 / m + 0.25 * l * l * inverse.x, 1e-12 * found.normal) << length;
    }
    const double r = radius, m = 1000 * 4.0 / 3 * M_PI * r * r * r;
    EXPECT_NEAR(contact_mobility(RodGroup(test::rigid_body(0, radius), 0, 0, "")).tangential, 3.5 / m, 1e-5 / m);
}

/// Balls stacked densely in a box that squeezes them by 1 % of their radius, each with 12 around it; they stick to each other.
SceneSpec stack(double share_of_limit) {
    SceneSpec scene;
    const double apart = 2 * radius * 0.99, cell = apart * std::sqrt(2.0);
    RodSpec balls = ball("balls", {0, 0, 0}, {0, 0, 0});
    balls.placement.kind = PlacementKind::list;
    constexpr int n = 3;
    for (int x = 0; x <= 2 * n; ++x)
        for (int y = 0; y <= 2 * n; ++y)
            for (int z = 0; z <= 2 * n; ++z)
                if ((x + y + z) % 2 == 0) balls.placement.origins.push_back((0.5 * cell) * Vec3d{double(x), double(y), double(z)});
    scene.rods = {balls};
    const ContactLaw law{
        .normal = ContactNormal::linear, .stiffness = 1e4, .friction = ContactFriction::memory, .static_friction = 1e9};
    scene.contact = ContactSpec{.law = law};
    Wall box;
    box.name = "box";
    box.kind = WallKind::box;
    const double out = 0.972 * radius, far = n * cell + out;
    box.lower = {-out, -out, -out}, box.upper = {far, far, far};
    box.law = {.normal = ContactNormal::linear, .stiffness = 1e4};
    scene.walls = {box};
    scene.time = {.duration = 1, .dt = 1e-9};
    scene.time.dt = share_of_limit * contact_time_limit(make_groups(scene)[0], law, 0.1).dt;
    scene.time.force_dt = true;
    return scene;
}

TEST(RigidBall, StaysWhereItIsInADenseStackAtItsContactLimit) {
    const auto speed = [](double share, std::int64_t steps) {
        Meeting stage(stack(share), 8);
        const std::size_t count = stage.rods->local().size();
        for (std::size_t i = 0; i < count; ++i) {
            std::vector<Slot<1>> state(2);
            stage.rods->export_rod(i, state);
            const double phase = static_cast<double>(i);
            for (Slot<1>& s : state)
                set_lane(s.velocity, 0, 1e-6 * Vec3d{std::sin(7.1 * phase), std::sin(5.3 * phase), std::sin(11.7 * phase)});
            set_lane(state[0].spin, 0,
                     (1e-6 / radius) * Vec3d{std::sin(3.1 * phase), std::sin(9.3 * phase), std::sin(8.7 * phase)});
            stage.rods->import_rod(i, state);
        }
        stage.advance(steps);
        double most = 0;
        for (std::size_t i = 0; i < count; ++i) most = std::max({most, norm(stage.velocity(i)), radius * norm(stage.spin(i))});
        return most;
    };
    // It is not quite in equilibrium, and sways at 0.14 m/s. The true limit is between 1.05 and 1.1.
    EXPECT_LT(speed(1.0, 3000), 0.2);
    EXPECT_GT(speed(1.15, 400), 1);
}

TEST(RigidBody, NeedsAStepWhereNothingLimitsIt) {
    SceneSpec scene;
    scene.rods = {test::rigid_body(0.1, radius)};
    scene.time = {.duration = 1};
    EXPECT_THROW(test::Stage{scene}, InputError);
    scene.time.dt = 1e-3;
    test::Stage stage(scene);
    EXPECT_EQ(stage.plan.groups[0].program.names(),
              (std::vector<std::string_view>{"drift (rigid)", "orthonormalise", "rigid", "kick (rigid)"}));
    EXPECT_NE(to_text(stage.plan).find("none (rigid)"), std::string::npos);
    stage.advance(100);
    EXPECT_TRUE(stage.rods->visit({}, true));
}

TEST(RigidBody, RefusesWhatItCannotHave) {
    const auto refusal = [](const std::function<void(SceneSpec&)>& change) -> std::string {
        SceneSpec scene;
        scene.rods = {test::rigid_body(0.1, radius)};
        scene.time = {.duration = 1, .dt = 1e-3};
        change(scene);
        try {
            check_scene(scene);
        } catch (const InputError& e) {
            return e.what();
        }
        return {};
    };
    EXPECT_EQ(refusal([](SceneSpec&) {}), "");
    EXPECT_EQ(refusal([](SceneSpec& s) {
                  s.loads = {{.load = Gravity{}},
                             {.load = UniformForce{.force = {1, 0, 0}}},
                             {.load = UniformCouple{}},
                             {.load = EndForce{.end = {1, 0, 0}}}};
              }),
              "");
    const std::pair<std::function<void(SceneSpec&)>, const char*> cases[] = {
        {[](SceneSpec& s) { s.rods[0].shape.elements = 2; }, "a rigid body is one element, and not 2"},
        {[](SceneSpec& s) { s.rods[0].material.youngs_modulus = 1; }, "'youngs_modulus' has no use in a rigid body"},
        {[](SceneSpec& s) { s.rods[0].section = {.kind = SectionKind::elliptic, .radius = 1, .radius_2 = 2}; },
         "a rigid body has a circular section"},
        {[](SceneSpec& s) {
             s.rods[0].shape.rest_curvature = {1, 0, 0};
         },
         "'rest_curvature' has no use in a rigid body"},
        {[](SceneSpec& s) { s.rods[0].start = EndKind::pinned; }, "the ends of a rigid body must be free"},
        {[](SceneSpec& s) { s.rods[0].hold.nodes = {0}; }, "a rigid body cannot be held"},
        {[](SceneSpec& s) { s.output.audit = true; }, "there is no audit of the rigid bodies of group 'body'"},
        {[](SceneSpec& s) { s.loads = {{.load = SlenderBodyDrag{.viscosity = 1}}}; }, "slender_body_drag is not for rigid bodies"},
        {[](SceneSpec& s) { s.loads = {{.load = PlaneFriction{}}}; }, "anisotropic_plane is not for rigid bodies"},
        {[](SceneSpec& s) { s.damping = {{.damping = {.kind = DampingKind::legacy, .rate = 1}}}; },
         "\"legacy\" is not for rigid bodies"},
    };
    for (const auto& [change, message] : cases)
        EXPECT_NE(refusal(change).find(message), std::string::npos) << refusal(change) << "\n" << message;
}

} // namespace
} // namespace skein
