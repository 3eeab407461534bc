// Twist to the last turn that frames can tell, compression to 0.3 and stretch to 3 of the length.
#include "loads/end_force.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "stress/stress_support.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>
#include <string>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

/// A thin rod twisted evenly between two clamps by `turn` rad per cell.
RodSpec twisted_rod(long n, double turn, EndKind ends) {
    RodSpec rod = test::simple_rod(n);
    rod.section = {.radius = 0.005};
    rod.start = rod.end = ends;
    rod.shape.start_curvature = Vec3d{0, 0, turn * static_cast<double>(n)};
    return rod;
}

/// Couples (about d3) that the first and the last element feel from their only neighbour, in units of G I3/L: one step
/// from rest of a twin without clamps, whose spins are then h c/J.
std::pair<double, double> end_couples(const RodSpec& spec, std::vector<Slot<1>> state, double dt) {
    SceneSpec scene;
    scene.rods = {spec};
    scene.rods[0].start = scene.rods[0].end = EndKind::free;
    scene.time = {.duration = 1, .dt = dt};
    test::Stage twin(scene, 1);
    for (Slot<1>& s : state) {
        set_lane(s.velocity, 0, Vec3d{0, 0, 0});
        set_lane(s.spin, 0, Vec3d{0, 0, 0});
    }
    twin.rods->import_rod(0, state);
    twin.advance(1);
    twin.rods->export_rod(0, state);
    const ElementConstants& e = twin.groups[0].element[0];
    const auto couple = [&](std::size_t k) {
        return lane(state[k].spin, 0).z * e.inertia.z / dt * spec.shape.length / e.bending.z;
    };
    return {couple(0), -couple(state.size() - 2)};
}

TEST(Twist, CoupleIsLinearUpToThreeRadiansPerCell) {
    constexpr long n = 20;
    double worst = 0;
    for (const double turn : {0.01, 0.1, 0.5, 1.0, 1.5, 2.0, 2.5, 2.9, 2.99}) {
        SceneSpec scene;
        scene.rods = {twisted_rod(n, turn, EndKind::clamped)};
        scene.time = {.duration = 2};
        scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 100}}};
        test::Stage stage(scene, 1);
        // Uneven at first: torsional waves run until the twist has spread evenly.
        auto state = stage.state(0);
        for (long k = 0; k < n; ++k)
            set_lane(nth(state, k).spin, 0, Vec3d{0, 0, 0.3 * std::cos(5.0 * static_cast<double>(k))});
        stage.rods->import_rod(0, state);
        test::advance_checked(stage, stage.plan.steps);
        const auto [first, last] = end_couples(scene.rods[0], stage.state(0), stage.plan.dt);
        const double exact = turn * n; // G I3 kappa over G I3/L
        const double error = std::max(std::abs(first - exact), std::abs(last - exact)) / exact;
        worst = std::max(worst, error);
        EXPECT_LE(error, 1e-6) << turn << " rad per cell";
    }
    std::printf("twist, n = %ld: couple linear to %.1e up to 2.99 rad per cell, %.2f turns of the (n - 1)/2 = %.1f "
                "that frames can tell\n",
                n, worst, 2.99 * n / (2 * pi), 0.5 * (n - 1));
}

TEST(Twist, BeyondIsAReportedError) {
    for (const double turn : {3.01, 3.1}) {
        SceneSpec scene;
        scene.rods = {twisted_rod(20, turn, EndKind::clamped)};
        scene.time = {.duration = 1};
        test::Stage stage(scene, 1);
        try {
            test::advance_checked(stage, 64);
            FAIL() << turn << " rad per cell went unnoticed";
        } catch (const NumericalError& e) {
            EXPECT_EQ(e.code(), Exit::numerical);
            EXPECT_NE(std::string(e.what()).find("more than 3 rad"), std::string::npos) << e.what();
        }
    }
}

/// One rod per axial force on its free end, from a push that leaves 0.3 of the length to a pull that makes it 3.
TEST(Stretch, FollowsTheLawFromThreeTenthsToThree) {
    const double target[] = {0.3, 0.4, 0.6, 0.8, 0.95, 1.05, 1.3, 1.7, 2.2, 3.0};
    SceneSpec scene;
    for (const double e : target) {
        RodSpec rod = test::simple_rod(20);
        rod.name = "e" + std::to_string(scene.rods.size());
        rod.start = EndKind::clamped;
        scene.rods.push_back(rod);
        const double axial = rod.material.youngs_modulus * pi * rod.section.radius * rod.section.radius;
        scene.loads.push_back(
            {.load = EndForce{.end = {0, 0, axial * (1 - 1 / e)}, .ramp = {1}}, .rods = {rod.name}}); // EA (e - 1)/e
    }
    scene.time = {.duration = 12, .e_min = 0.25};
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 40}}};
    test::Stage stage(scene, 1);
    test::advance_checked(stage, stage.plan.steps);
    double worst = 0;
    for (std::size_t i = 0; i < std::size(target); ++i) {
        const auto state = stage.state(i);
        for (std::size_t k = 0; k < 20; ++k)
            worst = std::max(worst, std::abs(test::dilatation(stage.groups[i], state, k) / target[i] - 1));
    }
    std::printf("axial force, e from 0.3 to 3: dilatation within %.1e of 1/(1 - F/EA)\n", worst);
    EXPECT_LE(worst, 1e-9);
}

/// Pinned rods held at the dilatations `e`, barely shaken.
std::unique_ptr<test::Stage> pulled_rods(const std::vector<double>& e, double shear_over_youngs, double time,
                                         Law law = Law::incompressible) {
    SceneSpec scene;
    RodSpec rod = test::simple_rod(20);
    rod.section = {.radius = 0.01};
    rod.material.shear_modulus = shear_over_youngs * rod.material.youngs_modulus;
    rod.material.law = law;
    rod.start = rod.end = EndKind::pinned;
    rod.placement = test::in_a_row(static_cast<long>(e.size()));
    scene.rods = {rod};
    scene.time = {.duration = time, .safety = 0.4}; // at e = 3 the limit is 0.64 of that at rest
    auto stage = std::make_unique<test::Stage>(scene);
    for (std::size_t i = 0; i < e.size(); ++i) {
        auto state = stage->state(i);
        const Vec3d origin = lane(state[0].position, 0);
        for (Slot<1>& s : state) set_lane(s.position, 0, origin + e[i] * (lane(s.position, 0) - origin));
        test::shake(state, 0, 1e-3, 7 + static_cast<unsigned>(i));
        stage->rods->import_rod(i, state);
    }
    return stage;
}

/// Largest angle between a director d3 and the axis z, over `time`.
std::vector<double> tilts(const std::vector<double>& e, double shear_over_youngs, double time) {
    const auto stage = pulled_rods(e, shear_over_youngs, time);
    std::vector<double> largest(e.size());
    for (int s = 1; s <= 200; ++s) {
        stage->advance(stage->plan.steps * s / 200);
        for (std::size_t i = 0; i < e.size(); ++i) {
            const auto state = stage->state(i);
            for (int k = 0; k < 20; ++k) {
                const Vec3d d3 = frame(nth(state, k)).d3;
                largest[i] = std::fmax(largest[i], std::atan2(std::hypot(d3.x, d3.y), d3.z));
            }
        }
    }
    return largest;
}

TEST(Stretch, DirectorsStandAlongAStretchedRod) {
    const std::vector<double> e = {1.1, 1.3, 1.45, 1.5, 1.75, 2.0, 2.5, 3.0};
    const auto tilt = tilts(e, 1.0 / 3, test::long_runs() ? 20 : 2);
    for (std::size_t i = 0; i < e.size(); ++i) {
        std::printf("pinned rod at e = %.2f: tilt up to %.1e\n", e[i], tilt[i]);
        EXPECT_LT(tilt[i], 1e-4) << "e = " << e[i];
    }
}

TEST(Stretch, TensionLimitIsWhereDirectorsFlip) {
    // G = E/5: unstable between the two roots of theory.md (15); the upper one is E/(2 a G)(1 + sqrt(1 - 4 a G/E)).
    RodSpec rod = test::simple_rod(20);
    rod.material.shear_modulus = rod.material.youngs_modulus / 5;
    const double limit = tension_limit(RodGroup(rod, 0, 0, "")), shear = rod.material.shear_factor / 5;
    const double upper = (1 + std::sqrt(1 - 4 * shear)) / (2 * shear);
    const auto tilt = tilts({0.99 * limit, 1.02 * limit, 2.0, 0.98 * upper, 1.03 * upper}, 0.2, 2);
    std::printf("G = E/5: e_c = %.3f, tilt at 0.99 and 1.02 of it %.1e %.1e; at e = 2 %.1e; upper root %.3f, at 0.98 "
                "and 1.03 of "
                "it %.1e %.1e\n",
                limit, tilt[0], tilt[1], tilt[2], upper, tilt[3], tilt[4]);
    EXPECT_LT(tilt[0], 1e-4);
    EXPECT_GT(tilt[1], 0.05);
    EXPECT_GT(tilt[2], 0.5);
    EXPECT_GT(tilt[3], 0.05);
    EXPECT_LT(tilt[4], 1e-4);
}

TEST(Stretch, PastTheTensionLimitARunIsStoppedByName) {
    for (const Law law : {Law::linear, Law::elastica}) {
        EXPECT_NO_THROW(test::advance_checked(*pulled_rods({1.45}, 1.0 / 3, 0.5, law), 5000));
        try {
            test::advance_checked(*pulled_rods({1.5}, 1.0 / 3, 0.5, law), 5000);
            FAIL() << "e = 1.5 went unnoticed";
        } catch (const NumericalError& e) {
            EXPECT_NE(std::string(e.what()).find("tension instability of element"), std::string::npos) << e.what();
            EXPECT_NE(std::string(e.what()).find("limit e_c = 1.474"), std::string::npos) << e.what();
        }
    }
}

/// Rods squeezed to 0.3 of their length between two clamps and shaken; the step planned for that. Elastic energy stored
/// at the start is some 0.5 EAL, far more than the cells take in bending.
std::unique_ptr<test::Stage> squeezed_rods(double rate) {
    constexpr double e = 0.3;
    SceneSpec scene;
    RodSpec rod = test::simple_rod(20);
    rod.section = {.radius = 0.05};
    rod.start = rod.end = EndKind::clamped;
    rod.placement = test::in_a_row(8);
    scene.rods = {rod};
    scene.time = {.duration = 2, .safety = 0.5, .e_min = e};
    if (rate > 0) scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = rate}}};
    auto stage = std::make_unique<test::Stage>(scene);
    for (unsigned i = 0; i < 8; ++i) {
        auto state = stage->state(i);
        const Vec3d origin = lane(state[0].position, 0);
        for (Slot<1>& s : state) set_lane(s.position, 0, origin + e * (lane(s.position, 0) - origin));
        test::shake(state, 0, 1e-3, 40 + i);
        stage->rods->import_rod(i, state);
    }
    return stage;
}

TEST(Compression, DampedRodsBuckleAndComeToRest) {
    const auto stage = squeezed_rods(500);
    auto before = test::energies(*stage);
    const auto start = before;
    double rise = 0, largest = 0;
    for (int s = 1; s <= 200; ++s) {
        test::advance_checked(*stage, stage->plan.steps * s / 200);
        const auto now = test::energies(*stage);
        for (std::size_t i = 0; i < now.size(); ++i) rise = std::fmax(rise, (now[i] - before[i]) / start[i]);
        before = now;
    }
    for (std::size_t i = 0; i < start.size(); ++i) largest = std::fmax(largest, before[i] / start[i]);
    std::printf("squeezed to 0.3 and damped: energy falls to %.3f of the start, never rising by more than %.1e of it\n",
                largest, rise);
    EXPECT_LE(rise, 1e-6);
    EXPECT_LE(largest, 0.1);
}

TEST(Compression, UndampedRodsAreStoppedByName) {
    try {
        const auto stage = squeezed_rods(0);
        test::advance_checked(*stage, stage->plan.steps);
        FAIL() << "rods whose cells must fold past 3 rad went on";
    } catch (const NumericalError& e) {
        EXPECT_NE(std::string(e.what()).find("more than 3 rad"), std::string::npos) << e.what();
        EXPECT_NE(std::string(e.what()).find("of 'rod', elements "), std::string::npos) << e.what();
    }
}

} // namespace
} // namespace skein
