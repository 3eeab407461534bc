// A million undamped steps: clamped rods keep their energy, free ones their momenta, all of them their frames.
#include "scene/make_groups.hpp"
#include "stress/stress_support.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace skein {
namespace {

constexpr std::int64_t steps = 1000000;
constexpr long rods = 8, n = 20;

/// Rods of one group, bent and twisted each in its own way at t = 0, straight at rest.
std::unique_ptr<test::Stage> bent_rods(EndKind start, double bend, double share_of_limit) {
    SceneSpec scene;
    RodSpec rod = test::simple_rod(n);
    rod.start = start;
    rod.placement = test::in_a_row(rods);
    scene.rods = {rod};
    scene.time = {.duration = 1, .dt = share_of_limit * time_limits(make_groups(scene)[0]).front().dt};
    auto stage = std::make_unique<test::Stage>(scene);
    for (unsigned i = 0; i < rods; ++i) {
        RodSpec bent = rod;
        bent.placement = {};
        const double share = (1.0 + i) / rods, axis = 2.4 * i;
        bent.shape.start_curvature =
            Vec3d{bend * share * std::cos(axis), bend * share * std::sin(axis), 1.5 * bend * (1 - share)};
        std::vector<Slot<1>> state(n + 1);
        RodGroup(bent, 0, 0, "").start_state(0, state);
        stage->rods->import_rod(i, state);
    }
    return stage;
}

TEST(LongRuns, ClampedRodsKeepTheirEnergy) {
    const auto stage = bent_rods(EndKind::clamped, 2, 0.2);
    const auto [energy, shadow] = test::watch_both(*stage, steps);
    const test::EnergyRecord w = test::worst(energy), s = test::worst(shadow);
    std::printf(
        "clamped rods, %.0e steps of %.3g: energy drift %.2e, last quarter minus first %.1e; shadow energy %.1e, %.1e; "
        "strain %.1f %%\n",
        static_cast<double>(steps), stage->plan.dt, w.drift, w.trend, s.drift, s.trend, 100 * w.strain);
    EXPECT_LE(w.drift, 1e-3);
    EXPECT_LE(std::abs(w.trend), 1e-4);
    EXPECT_LE(std::abs(s.trend), 1e-5);
}

TEST(LongRuns, SpinningRodsKeepMomentaAndFrames) {
    const auto stage = bent_rods(EndKind::free, 2, 0.5);
    const RodGroup& group = stage->groups[0];
    // Each turns as a whole at 8 rad/s about an axis of its own, and flies off.
    for (unsigned i = 0; i < rods; ++i) {
        const Vec3d rate{8 * std::sin(1.0 + i), 4 * std::cos(1.7 * i), 6};
        auto state = stage->state(i);
        for (Slot<1>& s : state) {
            set_lane(s.velocity, 0, Vec3d{0.1, 0.2, -0.1} + cross(rate, lane(s.position, 0)));
            set_lane(s.spin, 0, lane(s.director, 0) * rate);
        }
        set_lane(state.back().spin, 0, Vec3d{0, 0, 0});
        stage->rods->import_rod(i, state);
    }
    std::vector<test::Momenta> start;
    for (std::size_t i = 0; i < rods; ++i) start.push_back(test::momenta(group, stage->state(i)));
    double linear = 0, angular = 0, defect = 0, strain = 0;
    for (int sample = 1; sample <= 1000; ++sample) {
        test::advance_checked(*stage, steps * sample / 1000);
        for (std::size_t i = 0; i < rods; ++i) {
            const auto state = stage->state(i);
            const test::Momenta now = test::momenta(group, state);
            linear = std::max(linear, norm(now.linear - start[i].linear) / norm(start[i].linear));
            angular = std::max(angular, norm(now.angular - start[i].angular) / norm(start[i].angular));
            defect = std::max(defect, test::director_defect(state));
            for (std::size_t k = 0; k < n; ++k)
                strain = std::max(strain, std::abs(test::dilatation(group, state, k) - 1));
        }
    }
    std::printf(
        "spinning rods, %.0e steps of %.3g: momentum %.1e, angular momentum %.1e, |QQ^T - 1| %.1e; strain %.1f %%\n",
        static_cast<double>(steps), stage->plan.dt, linear, angular, defect, 100 * strain);
    EXPECT_LE(linear, 1e-10);
    EXPECT_LE(angular, 1e-10);
    EXPECT_LE(defect, 1e-12);
}

} // namespace
} // namespace skein
