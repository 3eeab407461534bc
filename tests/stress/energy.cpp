// Energy of free undamped rods: bounded, of second order in the step, without trend.         theory.md (8), (20)
// Bars of three sets of rods that the published law, having no potential, makes gain energy at any step.
#include "skein/core/error.hpp"
#include "stress/stress_support.hpp"
#include "support/free_rods.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

/// Half a turn of a helix, straight at rest: the geometry of the reference trajectory 01 (radius 0.3 m, rise 0.25 m).
std::unique_ptr<test::Stage> helical_rods(double dt, double duration, long rods, Law law = Law::incompressible) {
    constexpr long n = 20;
    std::vector<Vec3d> node;
    for (long k = 0; k <= n; ++k) {
        const double angle = pi * static_cast<double>(k) / n;
        node.push_back({0.3 * std::cos(angle), 0.3 * std::sin(angle), 0.25 * angle / pi});
    }
    SceneSpec scene;
    RodSpec rod = test::simple_rod(n);
    rod.material.law = law;
    rod.section = {.radius = 0.05};
    rod.shape.length = n * norm(node[1] - node[0]);
    rod.placement = test::in_a_row(rods);
    scene.rods = {rod};
    scene.time = {.duration = duration, .dt = dt};
    auto stage = std::make_unique<test::Stage>(scene);
    for (unsigned i = 0; i < rods; ++i) {
        auto state = test::along_curve(node, {1, 0, 0});
        if (i > 0) test::shake(state, 0.1, 1, i); // the first rod starts at rest
        stage->rods->import_rod(i, state);
    }
    return stage;
}

TEST(Energy, HelicalFreeRodFourSeconds) {
    double drift[3];
    const double dt[] = {4e-4, 2e-4, 1e-4};
    for (int i = 0; i < 3; ++i) {
        const auto stage = helical_rods(dt[i], 4, 8);
        const test::EnergyRecord w = test::worst(test::watch_energy(*stage, stage->plan.steps));
        drift[i] = w.drift;
        std::printf("helical free rods, 4 s, dt %.0e: energy drift %.2e, strain up to %.1f %%\n", dt[i], w.drift,
                    100 * w.strain);
    }
    EXPECT_LE(drift[1], 5e-4);
    EXPECT_GT(drift[1] / drift[2], 3.5);
    EXPECT_LT(drift[1] / drift[2], 4.5);
}

TEST(Energy, HelicalFreeRodHasNoTrendOverAMillionSteps) {
    double plain[2], trend[2], largest[2];
    const double dt[] = {2e-4, 1e-4};
    for (int i = 0; i < 2; ++i) {
        const std::int64_t steps = std::llround(200 / dt[i]);
        const auto stage = helical_rods(dt[i], 200, 8);
        const auto [energy, shadow] = test::watch_both(*stage, steps);
        plain[i] = test::mean_trend(energy);
        trend[i] = test::mean_trend(shadow);
        largest[i] = test::worst(shadow).drift;
        std::printf("helical free rods, %.0e steps of %.0e: energy drift %.2e, last quarter minus first %.1e; shadow "
                    "energy %.1e, %.1e\n",
                    static_cast<double>(steps), dt[i], test::worst(energy).drift, plain[i], largest[i], trend[i]);
    }
    EXPECT_LE(largest[0], 5e-5);
    EXPECT_NEAR(std::log2(plain[0] / plain[1]), 2, 0.4) << "what the energy itself wanders is of second order";
    EXPECT_GT(std::log2(trend[0] / trend[1]), 3.2) << "what the shadow energy wanders is of fourth order";
}

/// The step is `dt_over_dl` (0.01 s/m where published) times the element's length.
double butterfly_drift(long n, double dt_over_dl, Law law = Law::incompressible) {
    SceneSpec scene = test::butterfly(n);
    scene.rods[0].material.law = law;
    scene.time.dt = dt_over_dl * scene.rods[0].shape.length / static_cast<double>(n);
    test::Stage stage(scene, 1);
    test::fold(stage);
    const test::EnergyRecord w = test::worst(test::watch_energy(stage, stage.plan.steps, 4000));
    std::printf("butterfly n = %2ld, dt %.3f dl: energy drift %.2e, strain up to %.2f\n", n, dt_over_dl, w.drift,
                w.strain);
    return w.drift;
}

TEST(Energy, Butterfly) {
    for (const long n : {4, 10, 20, 40}) {
        const double drift = butterfly_drift(n, 0.01), half = butterfly_drift(n, 0.005);
        EXPECT_LE(drift, 1e-3) << "n = " << n;
        EXPECT_GT(drift / half, 3.5) << "n = " << n;
        EXPECT_LT(drift / half, 4.5) << "n = " << n;
    }
}

/// Eight thin rods bent by 5 to 7 rad about random axes across them, thrown about at 0.6 m/s and 19 rad/s.
std::unique_ptr<test::Stage> violent_rods(double dt, std::int64_t steps, Law law = Law::incompressible) {
    constexpr long n = 20, rods = 8;
    SceneSpec scene;
    RodSpec rod = test::simple_rod(n);
    rod.material.law = law;
    rod.section = {.radius = 0.01};
    rod.placement = test::in_a_row(rods);
    scene.rods = {rod};
    scene.time = {.duration = dt * static_cast<double>(steps), .dt = dt};
    auto stage = std::make_unique<test::Stage>(scene);
    for (unsigned i = 0; i < rods; ++i) {
        const double bend = 5 + 2.0 * i / (rods - 1), axis = 2.4 * i;
        RodSpec bent = rod;
        bent.placement = {};
        bent.shape.start_curvature = Vec3d{bend * std::cos(axis), bend * std::sin(axis), 0.5};
        std::vector<Slot<1>> state(n + 1);
        RodGroup(bent, 0, 0, "").start_state(0, state);
        test::shake(state, 0.6, 19, 100 + i);
        stage->rods->import_rod(i, state);
    }
    return stage;
}

TEST(Energy, ViolentFreeRodsAMillionSteps) {
    const auto stage = violent_rods(2e-5, 1000000);
    const auto records = test::watch_energy(*stage, 1000000, 10000);
    for (std::size_t i = 0; i < records.size(); ++i)
        std::printf("violent rod %zu: energy drift %.2e, last quarter minus first %.1e, strain up to %.1f %%\n", i,
                    records[i].drift, records[i].trend, 100 * records[i].strain);
    const test::EnergyRecord w = test::worst(records);
    EXPECT_LE(w.drift, 5e-5);
    EXPECT_LE(std::abs(w.trend), 5e-6);
}

TEST(LinearLaw, KeepsEnergyAsWell) {
    const test::EnergyRecord helical = test::worst(test::watch_energy(*helical_rods(2e-4, 4, 8, Law::linear), 20000));
    EXPECT_LE(helical.drift, 5e-4);
    for (const long n : {4, 40}) EXPECT_LE(butterfly_drift(n, 0.01, Law::linear), 1e-3) << "n = " << n;
    const test::EnergyRecord violent =
        test::worst(test::watch_energy(*violent_rods(2e-5, 200000, Law::linear), 200000, 10000));
    std::printf("linear law: helical rods %.2e, violent rods %.2e\n", helical.drift, violent.drift);
    EXPECT_LE(violent.drift, 5e-5);
}

/// The published law has no potential: it makes energy, whatever the step. That is why it is not the default.
TEST(PublishedLaw, MakesEnergy) {
    for (const double dt_over_dl : {0.01, 0.005}) {
        EXPECT_GT(butterfly_drift(4, dt_over_dl, Law::elastica), 0.05);
        EXPECT_THROW(butterfly_drift(20, dt_over_dl, Law::elastica), NumericalError) << "torn to pieces within 40 s";
    }
    const auto stage = violent_rods(2e-5, 1000000, Law::elastica);
    const auto before = test::energies(*stage);
    stage->advance(1000000);
    const auto after = test::energies(*stage);
    int lost = 0;
    for (std::size_t i = 0; i < after.size(); ++i) lost += !(after[i] < 1.5 * before[i]);
    std::printf("published law: %d of %zu violent rods lost within 1e6 steps\n", lost, after.size());
    EXPECT_GE(lost, 4);
}

} // namespace
} // namespace skein
