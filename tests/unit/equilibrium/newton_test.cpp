// Iterations of Newton's method: as many for any slenderness and number of elements, and quadratic at the end.
#include "equilibrium/newton.hpp"
#include "kernels/kernels.hpp"
#include "loads/end_force.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace skein {
namespace {

/// Cantilever of length 1 under a force on its tip, N/(E I/L^2).
Equilibrium solved(double slenderness, long n, double force, Law law = Law::linear) {
    SceneSpec scene;
    RodSpec rod = test::clamped_unit_rod(n, 1 / slenderness);
    rod.material.youngs_modulus = 1e9;
    rod.material.law = law;
    const double bending = 1e9 * 0.25 * std::numbers::pi / std::pow(slenderness, 4);
    scene.rods = {rod};
    scene.loads = {{.load = EndForce{.end = {force * bending, 0, 0}}}};
    scene.time.duration = 1;
    const std::vector<RodGroup> groups = make_groups(scene);
    const Plan plan = make_plan(scene, groups, {});
    const std::vector<LocalRod> rods = test::all_rods(groups);
    StaticSystem system(groups, rods, make_static_rods(plan, groups, rods, nullptr));
    StaticState state;
    state.slot.resize(to_index(groups[0].slots()));
    groups[0].start_state(0, state.slot);
    system.refresh(state);
    return NewtonSolver(system, {}).find(state, 1);
}

std::size_t all(const Equilibrium& found) {
    return std::accumulate(found.iterations.begin(), found.iterations.end(), std::size_t{0});
}

TEST(Newton, NeedsAsManyIterationsForAnySlendernessAndNumberOfElements) {
    for (const double force : {1.0, 20.0}) {
        std::size_t first = 0, most = 0, steps = 0;
        for (const double slenderness : {50, 500, 5000})
            for (const long n : {20, 100, 1000}) {
                const Equilibrium found = solved(slenderness, n, force);
                std::printf("newton: %g EI/L^2, L/r %g, n %ld: %zu load steps, %zu iterations\n", force, slenderness, n,
                            found.iterations.size(), all(found));
                EXPECT_TRUE(found.found) << found.reason;
                EXPECT_EQ(found.negative, 0);
                if (first == 0) first = all(found);
                most = std::max(most, all(found));
                steps = std::max(steps, found.iterations.size());
            }
        if (force == 1) {
            EXPECT_LE(most, 10U);
            EXPECT_EQ(steps, 1U);
        } else {
            EXPECT_LE(steps, 4U);
        }
        EXPECT_LE(most, first + 2) << force << " EI/L^2";
    }
}

TEST(Newton, ConvergesQuadratically) {
    for (const Law law : {Law::linear, Law::incompressible}) {
        const Equilibrium found = solved(50, 20, 3, law);
        ASSERT_TRUE(found.found) << found.reason;
        // Corrections above rounding: the last three of these.
        std::vector<double> size;
        for (const NewtonPass& pass : found.last.passes)
            if (pass.correction > 1e-13) size.push_back(pass.correction);
        ASSERT_GE(size.size(), 4U);
        for (std::size_t i = size.size() - 3; i < size.size(); ++i) {
            std::printf("newton: corrections %.2e, %.2e, ratio to the square %.2g\n", size[i - 1], size[i],
                        size[i] / (size[i - 1] * size[i - 1]));
            EXPECT_LT(size[i], 5 * size[i - 1] * size[i - 1]);
        }
    }
}

} // namespace
} // namespace skein
