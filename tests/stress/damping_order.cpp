// Second order in the step with every kind of damping, driven and swinging through large angles.      theory.md
// (22)-(24)
#include "loads/end_force.hpp"
#include "loads/muscle_wave.hpp"
#include "scene/make_groups.hpp"
#include "skein/core/index.hpp"
#include "stress/stress_support.hpp"
#include "support/dampers.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace skein {
namespace {

/// A clamped rod, bent at the start, driven by muscles and by a force on its tip that rises within a whole number of
/// steps.
std::vector<Slot<1>> end_state(const Damping& damping, std::int64_t steps, double& limit) {
    constexpr double duration = 0.4;
    SceneSpec scene;
    RodSpec rod = test::simple_rod(12);
    rod.material.density = 1000;
    rod.section = {.radius = 0.03};
    rod.start = EndKind::clamped;
    rod.shape.start_curvature = Vec3d{0.8, -0.5, 0.6};
    scene.rods = {rod};
    scene.time = {.duration = duration, .dt = duration / static_cast<double>(steps)};
    scene.loads.push_back(
        {.load = MuscleWave{
             .amplitude = 0.5, .period = 0.13, .wavelength = 1.2, .direction = {0.3, 1, 0.2}, .ramp = {0.1}}});
    scene.loads.push_back({.load = EndForce{.end = {0.4, 1.0, -0.3}, .ramp = {0.2}}});
    scene.damping.push_back({.damping = damping});
    test::Stage stage(scene, 1);
    limit = stage.plan.limit;
    test::advance_checked(stage, steps);
    return stage.state(0);
}

double distance(const std::vector<Slot<1>>& a, const std::vector<Slot<1>>& b) {
    double worst = 0;
    for (std::size_t k = 0; k < a.size(); ++k)
        worst = std::max(worst, norm(lane(a[k].position, 0) - lane(b[k].position, 0)));
    return worst;
}

TEST(DampingOrder, IsTwo) {
    for (const DampingKind kind : test::all_dampers()) {
        Damping damping = test::damper(kind);
        const double share =
            is_filter(damping) ? 0.3 : 3; // a filter's rate is that of the fastest modes: 0.12 a step here
        for (double* rate : {&damping.rate, &damping.translational, &damping.rotational}) *rate *= share;
        const char* const name = test::name_of(kind).data();
        double limit = 0, error[3];
        const std::int64_t coarse = 2000;
        const auto exact = end_state(damping, 32 * coarse, limit);
        for (int i = 0; i < 3; ++i) error[i] = distance(end_state(damping, coarse << i, limit), exact);
        std::printf("%-8s damping: error at %.2f, %.2f, %.2f of the limit: %.2e %.2e %.2e, ratios %.2f %.2f\n", name,
                    0.4 / coarse / limit, 0.2 / coarse / limit, 0.1 / coarse / limit, error[0], error[1], error[2],
                    error[0] / error[1], error[1] / error[2]);
        for (int i = 0; i < 2; ++i) {
            EXPECT_GE(error[i] / error[i + 1], 3.6) << name;
            EXPECT_LE(error[i] / error[i + 1], 4.4) << name;
        }
    }
}

// A filter or a rate that feeds any mode at all shows in 1e5 steps; the longest step is the automatic one of damped
// rods.
TEST(DampingOrder, EnergyOnlyFallsIn1e5Steps) {
    for (const DampingKind kind : test::all_dampers())
        for (const EndKind start : {EndKind::free, EndKind::clamped})
            for (const double share : {0.15, 0.855}) {
                SceneSpec scene;
                RodSpec rod = test::simple_rod(12);
                rod.section = {.radius = 0.03};
                rod.start = start;
                rod.shape.start_curvature = Vec3d{0.8, -0.5, 0.6};
                scene.rods = {rod};
                scene.time.duration = 1e3;
                scene.damping.push_back({.damping = test::damper(kind)});
                scene.time.dt = share * time_limits(make_groups(scene)[0]).front().dt;
                test::Stage stage(scene, 1);
                auto state = stage.state(0);
                if (start == EndKind::free) test::shake(state, 0.02, 1, 3);
                stage.rods->import_rod(0, state);
                const double first = test::energy(stage.groups[0], state);
                double most = 0;
                for (int part = 1; part <= 20; ++part) {
                    test::advance_checked(stage, part * 5000);
                    most = std::max(most, test::energy(stage.groups[0], stage.state(0)));
                }
                const double last = test::energy(stage.groups[0], stage.state(0));
                std::printf("%s, %s, at %.3f of the limit: energy at most %.6f, at last %.2e of the start's\n",
                            test::name_of(kind).data(), nth(end_names, start).data(), share, most / first,
                            last / first);
                EXPECT_LT(most, first);
            }
}

} // namespace
} // namespace skein
