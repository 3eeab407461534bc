// Friction of its own in every direction: against the formulae, element by element, and a snake that crawls.
#include "loads/load_list.hpp"
#include "loads/load_pass.hpp"
#include "loads/plane_friction.hpp"
#include "mechanics/elastic.hpp"
#include "mechanics/gyration.hpp"
#include "mechanics/kick.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi, radius = 0.02, weight = 9.81;
using State = std::vector<Slot<1>>;

PlaneFriction some_plane() {
    PlaneFriction plane;
    plane.point = {0.1, 0.2, 0.3};
    plane.normal = {0.1, -0.2, 2};
    plane.stiffness = 30;
    plane.damping = 0.2;
    plane.tolerance = 0.01;
    plane.kinetic_forward = 0.1;
    plane.kinetic_backward = 0.15;
    plane.kinetic_sideways = 0.2;
    plane.static_forward = 0.2;
    plane.static_backward = 0.3;
    plane.static_sideways = 0.4;
    plane.slip_speed = 0.5;
    return plane;
}

/// The formulae stage by stage, for all elements at a time, as the published code goes.
struct Plainly {
    const RodGroup& group;
    const State& state;
    std::vector<Vec3d> force, couple;

    Vec3d position(int i) const { return lane(nth(state, i).position, 0); }
    std::vector<Vec3d> of_elements() const {
        const int n = group.elements();
        std::vector<Vec3d> sums;
        for (int k = 0; k < n; ++k)
            sums.push_back((k == 0 ? 1.0 : 0.5) * nth(force, k) +
                           (k == n - 1 ? 1.0 : 0.5) * force[static_cast<std::size_t>(k) + 1]);
        return sums;
    }
    void give(int k, const Vec3d& f) {
        nth(force, k) += 0.5 * f;
        force[static_cast<std::size_t>(k) + 1] += 0.5 * f;
    }
    void add(const PlaneFriction& p) {
        const Vec3d up = (1 / norm(p.normal)) * p.normal;
        const auto n = static_cast<std::size_t>(group.elements());
        std::vector<Vec3d> all = of_elements(), along(n), across(n);
        std::vector<double> push(n), rest_along(n), rest_across(n), r(n), va(n), vb(n);
        const auto rest = [&](double speed) {
            return std::abs(speed) <= p.slip_speed ? 1
                                                   : std::abs(1 - std::min(1.0, std::abs(speed) / p.slip_speed - 1));
        };
        for (std::size_t k = 0; k < n; ++k) {
            const int at = static_cast<int>(k);
            const Vec3d edge = position(at + 1) - position(at), middle = 0.5 * (position(at + 1) + position(at));
            Vec3d a = edge - dot(edge, up) * up;
            along[k] = (1 / norm(a)) * a;
            across[k] = cross(along[k], up);
            r[k] = std::sqrt(group.element[k].volume / (pi * norm(edge)));
            const double m1 = group.node_mass[k], m2 = group.node_mass[k + 1];
            const Vec3d v = (1 / (m1 + m2)) * (m1 * lane(state[k].velocity, 0) + m2 * lane(state[k + 1].velocity, 0));
            const double gap = dot(up, middle - p.point) - r[k];
            va[k] = dot(v, along[k]);
            const Vec3d w = transpose_times(lane(state[k].director, 0), lane(state[k].spin, 0));
            vb[k] = dot(v + cross(w, -r[k] * up), across[k]);
            rest_along[k] = rest(va[k]);
            rest_across[k] = rest(vb[k]);
            if (gap > p.tolerance) continue;
            push[k] = -std::min(0.0, dot(all[k], up));
            give(at, (push[k] - p.stiffness * std::min(0.0, gap) - p.damping * dot(v, up)) * up);
        }
        for (std::size_t k = 0; k < n; ++k) {
            const double size = std::hypot(va[k], vb[k]), mu = va[k] > 0 ? p.kinetic_forward : p.kinetic_backward;
            const Vec3d f = (-(1 - rest_across[k]) * p.kinetic_sideways * push[k] * vb[k] / size) * across[k];
            give(static_cast<int>(k), (-(1 - rest_along[k]) * mu * push[k] * va[k] / size) * along[k]);
            roll(k, -r[k] * up, f);
        }
        all = of_elements();
        for (std::size_t k = 0; k < n; ++k) {
            const double fa = dot(all[k], along[k]), mu = fa > 0 ? p.static_forward : p.static_backward;
            const double torque = dot(transpose_times(lane(state[k].director, 0), couple[k]), along[k]);
            const double no_slip = -(r[k] * dot(all[k], across[k]) - 2 * torque) / (3 * r[k]);
            give(static_cast<int>(k),
                 (-std::copysign(std::min(std::abs(fa), rest_along[k] * mu * push[k]), fa)) * along[k]);
            roll(k, -r[k] * up,
                 std::copysign(std::min(std::abs(no_slip), rest_across[k] * p.static_sideways * push[k]), no_slip) *
                     across[k]);
        }
    }
    void roll(std::size_t k, const Vec3d& arm, const Vec3d& f) {
        give(static_cast<int>(k), f);
        couple[k] += lane(state[k].director, 0) * cross(arm, f);
    }
};

TEST(PlaneFriction, IsThePublishedFormula) {
    const RodGroup group(test::crooked_rod(7), 0, 0, "");
    for (const bool at_rest : {false, true})
        for (unsigned seed = 0; seed < 20; ++seed) {
            PlaneFriction plane = some_plane();
            if (!at_rest) plane.static_forward = plane.static_backward = plane.static_sideways = 0;
            State state = test::shaken_state(group, 0.01, 0.1, seed % 3 ? 0.3 : 2, seed);
            plane.point = lane(state[3].position, 0) - Vec3d{0, 0, 0.02};
            plane.normal = cross(lane(state[4].position, 0) - lane(state[2].position, 0), {0.3, 1, 0});
            std::vector<SlotLoad<1>> load(8, SlotLoad<1>{});
            Plainly plain{group, state, {}, {}};
            std::mt19937 random(seed);
            std::normal_distribution<double> normal;
            for (SlotLoad<1>& l : load) {
                set_lane(l.force, 0, {normal(random), normal(random), normal(random) - 2});
                set_lane(l.couple, 0, 0.02 * Vec3d{normal(random), normal(random), normal(random)});
                plain.force.push_back(lane(l.force, 0));
                plain.couple.push_back(lane(l.couple, 0));
            }
            plain.add(plane);
            LoadPass<PlaneFriction, 1>(plane, group).run(tile_of(group, state), load.data(), {});
            for (std::size_t i = 0; i < 8; ++i) {
                EXPECT_LT(norm(lane(load[i].force, 0) - plain.force[i]), 1e-13 * 5) << at_rest << seed << " node " << i;
                if (i == 7) continue;
                EXPECT_LT(norm(lane(load[i].couple, 0) - plain.couple[i]), 1e-14)
                    << at_rest << seed << " element " << i;
            }
        }
}

TEST(PlaneFriction, IsTheSameInAllLanes) {
    const RodGroup group(test::crooked_rod(7), 0, 0, "");
    std::vector<Slot<8>> wide(8);
    std::vector<SlotLoad<8>> wide_load(8, SlotLoad<8>{});
    std::vector<State> states;
    std::vector<std::vector<SlotLoad<1>>> loads(8, std::vector<SlotLoad<1>>(8, SlotLoad<1>{}));
    PlaneFriction plane = some_plane();
    plane.point = {0, 0, 0.3};
    for (int i = 0; i < 8; ++i) {
        states.push_back(test::shaken_state(group, 0.01, 0.1, 0.5, static_cast<unsigned>(i)));
        for (std::size_t k = 0; k < 8; ++k) {
            set_lane(wide[k], i, states.back()[k]);
            const Vec3d f{0.1 * i, 0.3, -static_cast<double>(k)};
            set_lane(wide_load[k].force, i, f);
            set_lane(nth(loads, i)[k].force, 0, f);
        }
    }
    const RodTile<8> tile{wide.data(), group.element.data(), group.voronoi.data(), &group, group.elements(), 0, {}, 8};
    LoadPass<PlaneFriction, 8>(plane, group).run(tile, wide_load.data(), {});
    for (int i = 0; i < 8; ++i) {
        auto& load = nth(loads, i);
        LoadPass<PlaneFriction, 1>(plane, group).run(tile_of(group, nth(states, i)), load.data(), {});
        for (std::size_t k = 0; k < 8; ++k) {
            EXPECT_EQ(norm(lane(wide_load[k].force, i) - lane(load[k].force, 0)), 0);
            EXPECT_EQ(norm(lane(wide_load[k].couple, i) - lane(load[k].couple, 0)), 0);
        }
    }
}

/// A straight rod on the floor, under gravity that leans by an angle, for a while.
State lie(const RodGroup& group, const PlaneFriction& plane, const Vec3d& pull, double duration, double dt) {
    State state(static_cast<std::size_t>(group.slots()));
    group.start_state(0, state);
    std::vector<std::unique_ptr<TilePass<1>>> program;
    program.push_back(std::make_unique<DriftPass<CircularGyration, 1>>());
    program.push_back(std::make_unique<ElasticPass<IncompressibleLaw, 1>>(Ends{}));
    program.push_back(make_pass<1>(Gravity{pull}, group));
    program.push_back(std::make_unique<LoadPass<PlaneFriction, 1>>(plane, group));
    program.push_back(std::make_unique<KickPass<KickKind::undamped, 1>>(KicksOfGroup{KickConstants(group, {}, dt)}));
    const RodTile<1> tile = tile_of(group, state);
    std::vector<SlotLoad<1>> load(state.size());
    for (const auto& pass : program) pass->bind(tile);
    Clock clock(dt, 0);
    for (const auto steps = static_cast<std::int64_t>(duration / dt); clock.done() < steps;) {
        const auto batch = clock.next(steps);
        for (const Step& step : batch)
            for (const auto& pass : program) pass->run(tile, load.data(), step);
        clock.advance(batch);
    }
    return state;
}

TEST(PlaneFriction, HoldsSlidesAndRolls) {
    RodSpec spec = test::simple_rod(8);
    spec.placement.tangent = {1, 0, 0};
    spec.placement.origin = {0, 0, radius};
    const RodGroup group(spec, 0, 0, "");
    PlaneFriction plane;
    plane.stiffness = 1;
    plane.damping = 1e-6;
    plane.slip_speed = 1e-4;
    plane.kinetic_forward = 0.1;
    plane.kinetic_backward = 0.15;
    plane.kinetic_sideways = 0.2;
    const double time = 0.5;
    const auto speed = [&](const Vec3d& pull) {
        return (1 / time) * lane(lie(group, plane, pull, time, 1e-4)[4].velocity, 0);
    };
    const auto leaning = [&](double slope, const Vec3d& way) {
        return weight * (std::sin(slope) * way + Vec3d{0, 0, -std::cos(slope)});
    };
    const Vec3d x{1, 0, 0}, y{0, 1, 0};
    // Sliding: in every direction by its own coefficient.
    const auto slides = [](double slope, double mu) { return weight * (std::sin(slope) - mu * std::cos(slope)); };
    EXPECT_NEAR(speed(leaning(0.3, x)).x, slides(0.3, 0.1), 0.01 * slides(0.3, 0.1));
    EXPECT_NEAR(speed(leaning(0.3, -x)).x, -slides(0.3, 0.15), 0.01 * slides(0.3, 0.15));
    EXPECT_NEAR(speed(leaning(0.9, y)).y, slides(0.9, 0.2), 0.01 * slides(0.9, 0.2));
    // Holding: below the static coefficient, whichever way it would slide; rolling: two thirds of the fall.
    plane.static_forward = 0.4;
    plane.static_backward = 0.6;
    plane.static_sideways = 0.4;
    EXPECT_LT(norm(speed(leaning(std::atan(0.38), x))), 1e-9);
    EXPECT_GT(norm(speed(leaning(std::atan(0.42), x))), 0.1);
    EXPECT_LT(norm(speed(leaning(std::atan(0.57), -x))), 1e-9);
    EXPECT_GT(norm(speed(leaning(std::atan(0.63), -x))), 0.1);
    EXPECT_NEAR(speed(leaning(0.2, y)).y, 2.0 / 3 * weight * std::sin(0.2), 0.01 * weight * std::sin(0.2));
}

} // namespace
} // namespace skein
