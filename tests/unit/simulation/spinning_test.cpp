// A straight rod that spins about an axis across it, stretched by its own inertia: with the linear law a node whose
// distance from the middle is X at rest goes round at x,  E A x'' = -rho A w^2 x,  x' = 1 at the ends,  so x = sin(k
// X)/(k cos(k L/2)), k = w sqrt(rho/E).
#include "support/energy.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

constexpr double k = 1, length = 1, density = 1000, young = 1e6; // x' is 1.14 in the middle

double radius_of(double at_rest) { return std::sin(k * at_rest) / (k * std::cos(0.5 * k * length)); }

SceneSpec spinning_scene(long elements, std::int64_t steps_per_turn) {
    const double w = k * std::sqrt(young / density);
    RodSpec rod = test::simple_rod(elements);
    rod.material = {.density = density, .youngs_modulus = young, .law = Law::linear};
    rod.placement.origin = {-0.5 * length, 0, 0};
    rod.placement.tangent = {1, 0, 0};
    rod.placement.normal = Vec3d{0, 1, 0};
    rod.shape.angular_velocity = {0, 0, w};
    SceneSpec scene;
    scene.rods = {rod};
    scene.time = {.duration = 10, .dt = 2 * M_PI / w / static_cast<double>(steps_per_turn)};
    return scene;
}

/// Begun where the closed form says.
struct Spinning : test::Stage {
    Spinning(long elements, std::int64_t steps_per_turn) : Stage(spinning_scene(elements, steps_per_turn), 1) {
        auto begin = state(0);
        const double w = scene.rods[0].shape.angular_velocity.z;
        for (std::size_t i = 0; i < begin.size(); ++i) {
            const double x = radius_of(length * (static_cast<double>(i) / static_cast<double>(elements) - 0.5));
            set_lane(begin[i].position, 0, Vec3d{x, 0, 0});
            set_lane(begin[i].velocity, 0, Vec3d{0, w * x, 0});
        }
        rods->import_rod(0, begin);
    }
};

/// Largest distance of a node from its circle in two turns, m.
double off_its_circle(long elements) {
    const std::int64_t turn = 100 * elements;
    Spinning stage(elements, turn);
    double most = 0;
    for (int part = 1; part <= 50; ++part) {
        stage.advance(part * turn / 25);
        const auto state = stage.state(0);
        for (std::size_t i = 0; i < state.size(); ++i) {
            const Vec3d x = lane(state[i].position, 0);
            const double at_rest = length * (static_cast<double>(i) / static_cast<double>(elements) - 0.5);
            most = std::max(most, std::abs(norm(x) - std::abs(radius_of(at_rest))));
            most = std::max(most, std::abs(x.z));
        }
    }
    return most;
}

TEST(SpinningRod, IsStretchedAsInClosedFormOrderTwo) {
    const double coarse = off_its_circle(8), middle = off_its_circle(16), fine = off_its_circle(32);
    EXPECT_LT(fine, 2e-4 * length);
    EXPECT_NEAR(std::log2(coarse / middle), 2, 0.15);
    EXPECT_NEAR(std::log2(middle / fine), 2, 0.1);
}

TEST(SpinningRod, KeepsItsMomentaAndItsEnergy) {
    Spinning stage(16, 1600);
    const RodGroup& group = stage.groups[0];
    const test::Momenta before = test::momenta(group, stage.state(0));
    const double energy = test::energy(group, stage.state(0));
    double most = 0;
    for (int part = 1; part <= 50; ++part) {
        stage.advance(part * 160);
        most = std::max(most, std::abs(test::energy(group, stage.state(0)) / energy - 1));
    }
    const test::Momenta after = test::momenta(group, stage.state(0));
    EXPECT_LT(norm(after.angular - before.angular), 1e-12 * norm(before.angular));
    EXPECT_LT(norm(after.linear), 1e-12 * norm(before.angular) / length);
    EXPECT_LT(most, 1e-6);
}

} // namespace
} // namespace skein
