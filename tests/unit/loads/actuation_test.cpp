// Couples at the ends and muscles about body axes against closed forms.                            theory.md (33a),
// (36a)
#include "mechanics/elastic.hpp"
#include "support/load_examples.hpp"
#include "support/statics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi, radius = 0.02, bending = pi / 4 * radius * radius * radius * radius;

RodSpec unit_rod(long n) {
    RodSpec spec = test::clamped_unit_rod(n, radius);
    spec.material.law = Law::linear;
    return spec;
}
Vec3d node(const test::State& s, std::size_t i) { return lane(s[i].position, 0); }
Vec3d turn(const test::State& s, std::size_t k) {
    return relative_rotation(lane(s[k + 1].director, 0), lane(s[k].director, 0));
}

/// At rest under a load that rises in eight parts.
test::State at_rest(const RodGroup& group, const std::function<Load(double)>& load) {
    test::Statics rod(group);
    for (int part = 1; part <= 8; ++part) {
        rod.loads = {load(part / 8.0)};
        rod.rest();
    }
    return rod.state;
}

// 2 pi EI/L rolls a rod up to a circle. Each cell, and the half cell at the wall, has the curvature M/EI to round-off,
// as nothing but M acts: the nodes are those of a regular polygon of n sides of length L/n, which closes, and is larger
// across than the circle by (pi/n)/sin(pi/n): second order.
TEST(EndCouple, RollsACantileverUpToACircle) {
    for (const LoadFrame frame : {LoadFrame::lab, LoadFrame::body}) {
        double before = 0;
        for (const long n : {8, 16, 32}) {
            const RodGroup group(unit_rod(n), 0, 0, "");
            const Vec3d axis{1, 0, 0}, lab = transpose_times(group.frame(), axis);
            const test::State s = at_rest(group, [&](double share) -> Load {
                return EndCouple{.end = 2 * pi * bending * share * (frame == LoadFrame::lab ? lab : axis),
                                 .frame = frame};
            });
            const double l = 1.0 / static_cast<double>(n);
            const auto last = static_cast<std::size_t>(n);
            for (std::size_t k = 0; k + 1 < last; ++k) EXPECT_LT(norm(turn(s, k) - 2 * pi * l * axis), 1e-9);
            EXPECT_LT(norm(relative_rotation(lane(s[0].director, 0), group.frame()) - pi * l * axis), 1e-9);
            EXPECT_LT(norm(node(s, last) - node(s, 0)), 1e-9);
            const double across = norm(node(s, last / 2) - node(s, 0)), error = across * pi - 1;
            EXPECT_NEAR(across, l / std::sin(pi * l), 1e-9);
            if (n > 8) {
                EXPECT_NEAR(std::log2(before / error), 2, 0.05);
            }
            before = error;
        }
    }
}

TEST(EndCouple, ActsOnTheEndElementsAlone) {
    const RodGroup group(test::crooked_rod(6), 0, 0, "");
    test::State state = test::shaken_state(group, 0.01, 0.4, 1);
    for (const LoadFrame frame : {LoadFrame::lab, LoadFrame::body}) {
        const EndCouple load{.start = {1, 2, 3}, .end = {-4, 5, 6}, .frame = frame, .ramp = {2}};
        std::vector<SlotLoad<1>> out(state.size(), SlotLoad<1>{});
        make_pass<1>(load, group)->run(test::tile_of(group, state), out.data(), Step{.index = 1, .dt = 1, .time = 0.5});
        for (std::size_t k = 0; k < 6; ++k) {
            const Vec3d c = 0.25 * (k == 0 ? load.start : k == 5 ? load.end : Vec3d{0, 0, 0});
            const Vec3d expected = frame == LoadFrame::lab ? lane(state[k].director, 0) * c : c;
            EXPECT_LE(norm(lane(out[k].couple, 0) - expected), 1e-15);
            EXPECT_EQ(norm(lane(out[k].force, 0)), 0);
        }
    }
}

/// A moment that is the same at all vertices and times.
MuscleWave steady(double moment, const Vec3d& axis) {
    return {.amplitude = moment,
            .period = 1e30,
            .wavelength = 1e30,
            .phase = pi / 2,
            .direction = axis,
            .frame = LoadFrame::body};
}

/// The muscles of either load as the moment A at all vertices and times, about d1 of a rod that begins in the lab's
/// axes.
std::vector<Load> steady_muscles(double moment) {
    std::vector<Load> all;
    for (const LoadFrame frame : {LoadFrame::lab, LoadFrame::body}) {
        MuscleWave wave = steady(moment, {1, 0, 0});
        wave.frame = frame;
        all.emplace_back(wave);
        all.emplace_back(MuscleTorques{.coefficients = std::vector<double>(6, moment),
                                       .period = 1e30,
                                       .phase = pi / 2,
                                       .direction = {1, 0, 0},
                                       .frame = frame});
    }
    return all;
}

// The moment A about d1 bends every cell, and the half cell at a clamp, to the curvature A/EI, to round-off: the nodes
// are those of a regular polygon along the arc, whose first side turns by half an angle from the clamp. Its chord is
// longer than that of the arc by (phi/2)/sin(phi/2), phi = A l/EI: place and turn of the tip are of second order.
TEST(Muscles, BendAClampedRodToAnArc) {
    const double curvature = 3;
    for (std::size_t kind = 0; kind < 4; ++kind)
        for (const bool at_end : {false, true}) {
            double before = 0;
            for (const long n : {8, 16}) {
                RodSpec spec = unit_rod(n);
                if (at_end) std::swap(spec.start, spec.end);
                const RodGroup group(spec, 0, 0, "");
                const test::State s =
                    at_rest(group, [&](double share) { return steady_muscles(share * curvature * bending)[kind]; });
                const double l = 1.0 / static_cast<double>(n);
                const auto last = static_cast<std::size_t>(n);
                for (std::size_t k = 0; k + 1 < last; ++k)
                    EXPECT_LT(norm(turn(s, k) - Vec3d{curvature * l, 0, 0}), 1e-9);
                const Vec3d half = at_end ? relative_rotation(group.end_frame(), lane(s[last - 1].director, 0))
                                          : relative_rotation(lane(s[0].director, 0), group.frame());
                EXPECT_LT(norm(half - Vec3d{0.5 * curvature * l, 0, 0}), 1e-9) << kind << at_end;
                const double chord = norm(node(s, last) - node(s, 0)), arc = 2 / curvature * std::sin(curvature / 2);
                EXPECT_NEAR(chord / arc, curvature * l / 2 / std::sin(curvature * l / 2), 1e-9);
                const Vec3d tip = group.frame() * (node(s, last) - node(s, 0)); // about d1 from d3 to -d2
                const double sign = at_end ? -1 : 1;
                const Vec3d exact = (1 / curvature) * Vec3d{0, -sign * (1 - std::cos(curvature)), std::sin(curvature)};
                const double error = norm(tip - exact);
                if (n > 8) {
                    EXPECT_NEAR(std::log2(before / error), 2, 0.05) << kind << at_end;
                }
                before = error;
            }
        }
}

// A moment A d is a change of the rest curvature by B^-1 A d: of the linear law to round-off, in any state.
TEST(MusclesAboutBodyAxes, AreAChangeOfRestCurvature) {
    RodSpec spec = test::simple_rod(7);
    spec.material.law = Law::linear;
    spec.material.shear_modulus = 4e5;
    const double moment = 0.02;
    const Vec3d axis{0.6, -0.5, 0.7};
    const RodGroup plain(spec, 0, 0, "");
    const Vec3d stiffness = plain.voronoi[0].stiffness;
    spec.shape.rest_curvature = moment * Vec3d{axis.x / stiffness.x, axis.y / stiffness.y, axis.z / stiffness.z};
    const RodGroup curved(spec, 0, 0, "");
    for (unsigned seed = 1; seed <= 5; ++seed) {
        test::State state = test::shaken_state(plain, 0.01, 0.3, 1, seed);
        std::vector<SlotLoad<1>> one(state.size(), SlotLoad<1>{}), other = one;
        const Step step{.index = 1, .dt = 1, .time = 1, .slot = 0};
        with_energy_law(Law::linear, [&]<class L>(L) {
            ElasticPass<L, 1>({}).run(test::tile_of(plain, state), one.data(), step);
            ElasticPass<L, 1>({}).run(test::tile_of(curved, state), other.data(), step);
        });
        const auto pass = make_pass<1>(steady(moment, axis), plain);
        pass->prepare(std::span(&step, 1));
        pass->run(test::tile_of(plain, state), one.data(), step);
        for (std::size_t k = 0; k < 7; ++k) {
            EXPECT_LE(norm(lane(one[k].couple, 0) - lane(other[k].couple, 0)), 1e-13);
            EXPECT_LE(norm(lane(one[k].force, 0) - lane(other[k].force, 0)), 1e-11);
        }
    }
}

} // namespace
} // namespace skein
