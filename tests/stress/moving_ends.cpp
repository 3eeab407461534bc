// Ends that walls move to the limits of rods: twist to the last turn that frames can tell, 0.3 and 3 of the length.
#include "diagnostics/energy_audit.hpp"
#include "skein/core/error.hpp"
#include "stress/stress_support.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

/// The end goes there in 4 s, slowly enough that twist spreads evenly: 3 rad are the end of the run.
SceneSpec moved(const RodSpec& rod, const Vec3d& translation, const Vec3d& rotation, double rate, double e_min) {
    SceneSpec scene;
    scene.rods = {rod};
    scene.rods[0].start = scene.rods[0].end = EndKind::clamped;
    scene.rods[0].end_motion = {
        .times = {0, 4}, .translation = {{0, 0, 0}, translation}, .rotation = {{0, 0, 0}, rotation}, .smooth = true};
    scene.time = {.duration = 6, .e_min = e_min};
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = rate}}};
    scene.output.audit = true;
    return scene;
}

/// Share of what the walls put in that is missing from what is stored and dissipated.
double missing(const test::Stage& stage) {
    const EnergyAudit a = audit_rod(stage.groups, *stage.rods, 0, stage.clock.time(), stage.clock.lag());
    return std::abs(a.defect(0)) / a.walls;
}

TEST(MovingEnds, TwistByAWallUpToThreeRadiansPerCell) {
    constexpr long n = 20;
    RodSpec rod = test::simple_rod(n);
    rod.section = {.radius = 0.005};
    for (const double turn : {0.5, 1.5, 2.5, 2.99}) {
        const double angle = turn * n;
        test::Stage stage(moved(rod, {0, 0, 0}, {0, 0, angle}, 20, 0.95), 1);
        test::advance_checked(stage, stage.plan.steps);
        const double exact = 0.5 * stage.groups[0].element[0].bending.z * angle * angle;
        const double error =
            std::abs(rod_energy(stage.groups[0], stage.state(0), stage.clock.time()).twist / exact - 1);
        std::printf("wall turned by %.2f turns, %.2f rad per cell: energy within %.1e of G I3 a^2/(2 L), %.1e of the "
                    "work missing\n",
                    angle / (2 * pi), turn, error, missing(stage));
        EXPECT_LE(error, 1e-6) << turn;
        EXPECT_LE(missing(stage), 1e-6) << turn;
    }
}

TEST(MovingEnds, TwistBeyondIsAReportedError) {
    RodSpec rod = test::simple_rod(20);
    rod.section = {.radius = 0.005};
    test::Stage stage(moved(rod, {0, 0, 0}, {0, 0, 3.1 * 20}, 20, 0.95), 1);
    try {
        test::advance_checked(stage, stage.plan.steps);
        FAIL() << "3.1 rad per cell went unnoticed";
    } catch (const NumericalError& e) {
        EXPECT_NE(std::string(e.what()).find("more than 3 rad"), std::string::npos) << e.what();
    }
}

TEST(MovingEnds, LengthsFromThreeTenthsToThree) {
    for (const double e : {0.3, 0.5, 0.8, 1.5, 2.0, 3.0}) {
        test::Stage stage(moved(test::simple_rod(20), {0, 0, e - 1}, {0, 0, 0}, 40, 0.25), 1);
        test::advance_checked(stage, stage.plan.steps);
        const auto state = stage.state(0);
        double worst = 0;
        for (std::size_t k = 0; k < 20; ++k)
            worst = std::max(worst,
                             std::abs(20 * (lane(state[k + 1].position, 0).z - lane(state[k].position, 0).z) / e - 1));
        const double exact = stage.groups[0].element[0].stiffness.z * (e - 1 - std::log(e));
        const double error = std::abs(rod_energy(stage.groups[0], state, stage.clock.time()).stretch / exact - 1);
        std::printf("end moved to e = %.2f: dilatation within %.1e, energy within %.1e of EA L (e - 1 - ln e), %.1e of "
                    "the work missing\n",
                    e, worst, error, missing(stage));
        EXPECT_LE(worst, 1e-8) << e;
        EXPECT_LE(error, 1e-8) << e;
        EXPECT_LE(missing(stage), 1e-6) << e;
    }
}

} // namespace
} // namespace skein
