// The same rod, small or large, soft or stiff: the same dimensionless motion. A constant with a hidden unit would show.
#include "loads/end_force.hpp"
#include "loads/gravity.hpp"
#include "loads/magnetic_field.hpp"
#include "loads/muscle_wave.hpp"
#include "stress/stress_support.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

namespace skein {
namespace {

struct Curve {
    std::int64_t steps = 0;
    std::vector<Vec3d> position; ///< in lengths of the rod, nodes of ten times
};

/// Times are in units of L sqrt(rho/E), lengths of L, forces of E L^2. Magnetic fields are taken as B with strength
/// E/B.
Curve motion(double length, double youngs) {
    constexpr double density = 1000, radius = 0.03, duration = 60;
    const double time = length * std::sqrt(density / youngs);
    SceneSpec scene;
    RodSpec rod;
    rod.name = "rod";
    rod.material = {.density = density, .youngs_modulus = youngs};
    rod.section = {
        .kind = SectionKind::elliptic, .radius = radius * length, .radius_2 = 0.7 * radius * length, .taper = 0.6};
    rod.shape = {.length = length, .elements = 16};
    rod.shape.rest_curvature = (1 / length) * Vec3d{0.4, -0.2, 0.3};
    rod.shape.start_curvature = (1 / length) * Vec3d{1.0, 0.3, -0.4};
    rod.start = EndKind::clamped;
    rod.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = youngs};
    scene.rods = {rod};
    scene.time = {.duration = duration * time};
    scene.loads = {{.load = Gravity{.acceleration = (length / (time * time)) * Vec3d{1e-3, 0, -1e-3}}},
                   {.load = EndForce{.end = (youngs * length * length) * Vec3d{0, 2e-7, 0}, .ramp = {20 * time}}},
                   {.load = MagneticField{.rotating = 1e-4, .period = 30 * time, .ramp = {5 * time}}},
                   {.load = MuscleWave{.amplitude = 1e-7 * youngs * length * length * length,
                                       .period = 17 * time,
                                       .wavelength = length,
                                       .ramp = {5 * time}}}};
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 0.02 / time}}};
    test::Stage stage(scene, 1);
    Curve curve{.steps = stage.plan.steps};
    for (int frame = 1; frame <= 10; ++frame) {
        test::advance_checked(stage, stage.plan.steps * frame / 10);
        for (const Slot<1>& s : stage.state(0)) curve.position.push_back((1 / length) * lane(s.position, 0));
    }
    return curve;
}

double apart(const Curve& a, const Curve& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.position.size(); ++i) most = std::max(most, norm(a.position[i] - b.position[i]));
    return most;
}

TEST(Ladders, SizeFromAMicrometreToAKilometre) {
    const Curve one = motion(1, 1e6);
    double largest = 0;
    for (int power = -6; power <= 3; ++power) {
        const Curve other = motion(std::pow(10, power), 1e6);
        EXPECT_EQ(other.steps, one.steps) << "L = 1e" << power;
        largest = std::max(largest, apart(other, one));
    }
    const Vec3d moved = one.position.back() - one.position[one.position.size() / 10 - 1];
    std::printf("size ladder, 1e-6 m to 1e3 m: %lld steps, tip moved by %.2f L between frames, curves apart by %.1e\n",
                static_cast<long long>(one.steps), norm(moved), largest);
    EXPECT_LE(largest, 1e-9);
    EXPECT_GT(norm(moved), 0.05) << "a rod at rest would prove nothing";
}

TEST(Ladders, StiffnessFromGelToDiamond) {
    const Curve one = motion(1, 1e6);
    double largest = 0;
    for (int power = 3; power <= 12; ++power) {
        const Curve other = motion(1, std::pow(10, power));
        EXPECT_EQ(other.steps, one.steps) << "E = 1e" << power;
        largest = std::max(largest, apart(other, one));
    }
    std::printf("stiffness ladder, 1e3 Pa to 1e12 Pa: curves apart by %.1e\n", largest);
    EXPECT_LE(largest, 1e-9);
}

} // namespace
} // namespace skein
