// Iterations of Newton's method: as many for any slenderness and number of elements, and quadratic at the end.
#include "equilibrium/newton.hpp"
#include "kernels/kernels.hpp"
#include "loads/end_force.hpp"
#include "parallel/communicator.hpp"
#include "scene/scene_file.hpp"
#include "studies/scene_family.hpp"
#include "support/scenes_for_tests.hpp"

#include <fmt/format.h>
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

/// So many pairs of sticks that cross, of which the upper lies on the lower one.
SceneText crossed_pairs(int pairs) {
    return {"pairs.toml",
            fmt::format(R"toml(
time.duration = 1.0
[[rods]]
name = "lower"
start = "clamped"
material = {{density = 1000.0, youngs_modulus = 1e7}}
section.radius = 2e-3
shape = {{length = 0.05, elements = 3}}
placement = {{kind = "line", counts = [{0}], spacing = [0.2], origin = [0.0, 0.0, 0.0], tangent = [1, 0, 0]}}
[[rods]]
name = "upper"
start = "clamped"
material = {{density = 1000.0, youngs_modulus = 1e6}}
section.radius = 2e-3
shape = {{length = 0.05, elements = 3}}
placement = {{kind = "line", counts = [{0}], spacing = [0.2], origin = [0.03, -0.03, 0.0041], tangent = [0, 1, 0]}}
[[load]]
kind = "gravity"
[contact]
stiffness = 100.0
friction = "none"
)toml",
                        pairs),
            {}};
}

TEST(Newton, HeapsAreSolvedByIteration) {
    int no_words = 0;
    char** none = nullptr;
    const MpiSession session(no_words, none); // PETSc is for processes that have MPI
    const auto one = static_case(crossed_pairs(1), {}, 1), heap = static_case(crossed_pairs(500), {}, 1);
    EXPECT_FALSE(one->system->is_heap());
    ASSERT_TRUE(heap->system->is_heap());
    StaticState single = start_of(*one->system, one->groups, one->rods),
                many = start_of(*heap->system, heap->groups, heap->rods);
    const StaticState start = many;
    const Equilibrium of_one = NewtonSolver(*one->system, {}).find(single, 1),
                      of_heap = NewtonSolver(*heap->system, {}).find(many, 1);
    ASSERT_TRUE(of_one.found) << of_one.reason;
    ASSERT_TRUE(of_heap.found) << of_heap.reason;
    EXPECT_EQ(of_heap.factor, "sparse factors of rods and rigid motions (conjugate gradients)");
    EXPECT_EQ(of_heap.negative, 0);
    EXPECT_EQ(of_one.negative, 0);
    // The upper stick is bent by the lower one.
    const std::size_t slots = heap->system->first_slot(1), rods = heap->rods.size();
    double farthest = 0, moved = 0;
    for (std::size_t i = 0; i < rods; ++i)
        for (std::size_t k = 0; k < slots; ++k) {
            const auto place = [](const StaticState& state, std::size_t s) { return lane(state.slot[s].position, 0); };
            const std::size_t s = heap->system->first_slot(i) + k,
                              alike = one->system->first_slot(i < rods / 2 ? 0 : 1) + k;
            const Vec3d away = place(many, s) - place(start, s),
                        expected = place(single, alike) - place(start_of(*one->system, one->groups, one->rods), alike);
            farthest = std::max(farthest, norm(away - expected));
            moved = std::max(moved, norm(away));
        }
    EXPECT_GT(moved, 1e-4);
    EXPECT_LT(farthest, 1e-9 * 0.05);
}

} // namespace
} // namespace skein
