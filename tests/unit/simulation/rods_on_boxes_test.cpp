// Rods that hit boxes flush, tilted, across an edge and beside a vertex: momenta and energy stay, damped ones lose as
// much as their dashpots take; rods that lie on a box bear its reaction and stay where they are.
#include "loads/gravity.hpp"
#include "scene/make_groups.hpp"
#include "support/meeting.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

using test::Meeting;

constexpr double radius = 0.01, edge_radius = 0.005;

struct Hit {
    const char* name;
    Vec3d above, tangent, normal, up; ///< of the rod's middle over the box's centre; of the rod; axes of the box
};

/// A face is at 0.03 from the centre, an edge at 0.0525 sideways and 0.025 up.
std::vector<Hit> hits() {
    const double face = 0.03 + radius, s = std::sqrt(0.5), edge = (0.055 + 0.025) * s + edge_radius + radius;
    return {{"flush on a face", {0, 0.01, face}, {1, 0, 0}, {1, 0, 0}, {0, 0, 1}},
            {"flush, with an end over the face", {0.063, 0.01, face}, {1, 0.1, 0}, {1, 0, 0}, {0, 0, 1}},
            {"tilted", {0.02, 0, face + 0.001}, {1, 0.3, 0.01}, {1, 0, 0}, {0, 0, 1}},
            {"across an edge", {-(0.055 - 0.025) * s, 0.007, edge}, {1, 0.2, 0.02}, {s, 0, -s}, {s, 0, s}},
            {"along an edge", {-(0.055 - 0.025) * s, 0.007, edge}, {0, 1, 0}, {s, 0, -s}, {s, 0, s}},
            {"beside a vertex", {0.055, 0.04, face}, {1, -1, 0.005}, {1, 0, 0}, {0, 0, 1}}};
}

/// `later`: share of a step by which they meet.
SceneSpec scene_of(const Hit& hit, const ContactLaw& law, double dt, double later) {
    SceneSpec scene;
    RodSpec rod = test::simple_rod(8), box = test::box_body({0.12, 0.1, 0.06});
    const double length = 0.2, speed = 1;
    rod.section.radius = radius;
    rod.material.youngs_modulus = 1e8;
    rod.shape.length = length;
    rod.shape.velocity = {0.2, 0.1, -speed};
    rod.placement.tangent = hit.tangent;
    rod.placement.origin =
        hit.above - (0.5 * length) * unit(hit.tangent) + Vec3d{0, 0, (1 + later) * speed * dt + 1e-4};
    box.name = "box";
    box.placement.tangent = hit.up;
    box.placement.normal = hit.normal;
    scene.rods = {rod, box};
    scene.contact = ContactSpec{.law = law};
    scene.time = {.duration = 1, .dt = dt};
    scene.time.force_dt = true;
    return scene;
}

/// Change of the energy over that before; momenta stay.
double change_in(const SceneSpec& scene, double duration) {
    Meeting stage(scene);
    const double energy = stage.energy();
    const test::Momenta before = stage.momenta();
    stage.advance(std::llround(duration / scene.time.dt));
    EXPECT_TRUE(stage.touched);
    EXPECT_EQ(stage.contacts->figures().active, 0) << "they have parted";
    const test::Momenta after = stage.momenta();
    EXPECT_LT(norm(after.linear - before.linear), 1e-12 * norm(before.linear));
    EXPECT_LT(norm(after.angular - before.angular), 1e-12 * (norm(before.angular) + 0.1 * norm(before.linear)));
    const double dissipated =
        stage.contacts->figures().viscous_work.value() + stage.contacts->figures().friction_work.value();
    EXPECT_EQ(dissipated > 0.05 * energy, scene.contact->law.damping > 0);
    return (stage.energy() + dissipated - energy) / energy;
}

/// Root of the mean square over places within a step where the contact begins, and its order over two divisions by 4.
struct Convergence {
    double off[3];
    double order() const { return 0.25 * std::log2(off[0] / off[2]); }
};
Convergence convergence(const Hit& hit, const ContactLaw& law) {
    Convergence c{};
    for (const int i : {0, 1, 2}) {
        const double dt = 2e-5 / (1 << 2 * i);
        const int places = 8;
        double sum = 0;
        for (int k = 0; k < places; ++k) {
            const double one = change_in(scene_of(hit, law, dt, static_cast<double>(k) / places), 0.01);
            sum += one * one / places;
        }
        c.off[i] = std::sqrt(sum);
    }
    return c;
}

TEST(RodsOnBoxes, ThatHitKeepMomentaAndEnergy) {
    for (const ContactNormal normal : {ContactNormal::linear, ContactNormal::hertz})
        for (const Hit& hit : hits()) {
            const auto c =
                convergence(hit, {.normal = normal, .stiffness = normal == ContactNormal::linear ? 1e5 : 3e6});
            EXPECT_GT(c.order(), 1.8) << hit.name << ": " << c.off[0] << " " << c.off[1] << " " << c.off[2];
            EXPECT_LT(c.off[2], 1e-5) << hit.name;
        }
}

// Works of dashpots are those of forces half a step apart, so the sum closes to first order.
TEST(RodsOnBoxes, ThatHitWithDampingLoseTheWorkOfTheirDashpots) {
    for (const Hit& hit : hits()) {
        const auto c = convergence(hit, {.normal = ContactNormal::linear,
                                         .stiffness = 1e5,
                                         .damping = 10,
                                         .friction = ContactFriction::memory,
                                         .static_friction = 0.3});
        EXPECT_LT(c.off[2], 1e-3) << hit.name;
        EXPECT_LT(c.off[2], 0.1 * c.off[0]) << hit.name;
    }
}

/// A stiff rod along x on a box, over whose edges it hangs on both sides; gravity leans by `slope`.
SceneSpec lying(double slope, double friction, double stiffness) {
    SceneSpec scene;
    RodSpec rod = test::simple_rod(8), box = test::box_body({0.12, 0.1, 0.06});
    rod.section.radius = radius;
    rod.material.youngs_modulus = 1e9;
    rod.shape.length = 0.2;
    rod.placement.tangent = {1, 0, 0};
    rod.placement.origin = {-0.1, 0, 0.06 + radius};
    box.name = "box";
    box.placement.origin = {0, 0, 0.03};
    scene.rods = {rod, box};
    const auto law = [](double k, double c, double mu) {
        return ContactLaw{.normal = ContactNormal::linear,
                          .stiffness = k,
                          .damping = c,
                          .friction = ContactFriction::memory,
                          .static_friction = mu,
                          .tangential_damping = c};
    };
    scene.contact = ContactSpec{.law = law(stiffness, 10, friction)};
    Wall floor;
    floor.name = "floor";
    floor.law = law(1e5, 100, 2);
    scene.walls = {floor};
    scene.loads = {{.load = Gravity{{test::gravity * std::sin(slope), 0, -test::gravity * std::cos(slope)}}}};
    scene.time = {.duration = 1, .dt = 5e-6};
    scene.time.force_dt = true;
    return scene;
}

struct OnRod {
    double mass = 0;
    Vec3d force{0, 0, 0}, place{0, 0, 0}, velocity{0, 0, 0}; ///< force of contact; means of place and velocity

    explicit OnRod(const Meeting& stage) {
        const auto state = stage.state(0);
        for (std::size_t k = 0; k < state.size(); ++k) {
            const double m = stage.groups[0].node_mass[k];
            mass += m;
            force += stage.around.loads->load[k].force;
            place += m * lane(state[k].position, 0);
            velocity += m * lane(state[k].velocity, 0);
        }
        place = (1 / mass) * place;
        velocity = (1 / mass) * velocity;
    }
};

// Five nodes over the face and two edges bear as much each.
TEST(RodsOnBoxes, ThatLieOnThemBearTheirWeightAndStay) {
    for (const double slope : {0.0, 0.2}) {
        const double k = 1e3;
        SceneSpec scene = lying(slope, 0.3, k);
        scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 20}}};
        Meeting stage(scene);
        stage.advance(200000);
        const OnRod before(stage);
        const double weight = before.mass * test::gravity;
        EXPECT_NEAR(before.force.z, std::cos(slope) * weight, 1e-4 * weight);
        EXPECT_NEAR(before.force.x, -std::sin(slope) * weight, 1e-4 * weight);
        EXPECT_NEAR(stage.contacts->figures().weight, 7, 0.5);
        const double overlap = stage.contacts->figures().max_overlap * 2 * edge_radius;
        EXPECT_NEAR(overlap, std::cos(slope) * weight / (7 * k), 0.1 * overlap) << "the elements sag";
        stage.advance(40000);
        EXPECT_LT(norm(OnRod(stage).place - before.place), 1e-9) << "it creeps";
    }
}

// Along itself, so that one node after another comes over the face and leaves it.
TEST(RodsOnBoxes, ThatSlideOverEdgesFeelTheirFriction) {
    const double slope = 0.4, friction = 0.8 * std::tan(slope);
    SceneSpec scene = lying(slope, friction, 1e4);
    scene.rods[0].shape.velocity = {0.3, 0, 0};
    scene.rods[0].placement.origin.x = -0.12;
    Meeting stage(scene);
    stage.advance(4000);
    const OnRod before(stage);
    stage.advance(16000);
    const OnRod after(stage);
    const double free = test::gravity * std::sin(slope) * 16000 * scene.time.dt;
    EXPECT_GT(after.place.x - before.place.x, 0.025) << "more than an element";
    EXPECT_NEAR(after.velocity.x - before.velocity.x, 0.2 * free, 2e-3 * free);
}

} // namespace
} // namespace skein
