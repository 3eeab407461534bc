// J1 != J2: the split top and the elliptic rod are of second order, reversible, and keep the angular momentum.
// theory.md (19)
#include "mechanics/rod_copies.hpp"
#include "stress/stress_support.hpp"
#include "support/free_top.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace skein {
namespace {

TEST(Elliptic, FreeTopAgainstJacobi) {
    for (const double ratio : {2.0, 4.0, 0.5, 0.25}) {
        const RodGroup group(test::elliptic_rod(ratio, 2), 0, 0, "");
        const Vec3d j = group.element[0].inertia;
        const double small_rate = 0.7, w3 = 0.9, time = 20;
        const Vec3d start = j.x < j.y ? Vec3d{small_rate, 0, w3} : Vec3d{0, small_rate, w3};
        double error[3], turned[3], momentum = 0, back = 0;
        for (int i = 0; i < 3; ++i) {
            const int steps = 400 << i;
            std::vector<Slot<1>> state(3);
            group.start_state(0, state);
            for (Slot<1>& s : state) set_lane(s.spin, 0, start);
            const auto begin = state;
            const auto lab = [&] {
                return transpose_times(lane(state[0].director, 0), scale(j, lane(state[0].spin, 0)));
            };
            const Vec3d before = lab();
            error[i] = 0;
            for (int s = 1; s <= steps; ++s) {
                synchronise(group, state, time / steps);
                error[i] = std::fmax(
                    error[i],
                    norm(lane(state[0].spin, 0) - test::free_top(j, small_rate, w3, time * s / steps)) / norm(start));
                momentum = std::max(momentum, norm(lab() - before) / norm(before));
            }
            const Mat3d q = frame(state[0]),
                        exact = test::free_top_directors(j, small_rate, w3, time, lane(begin[0].director, 0));
            turned[i] = std::max({norm(q.d1 - exact.d1), norm(q.d2 - exact.d2), norm(q.d3 - exact.d3)});
            for (int s = 0; s < steps; ++s) synchronise(group, state, -time / steps);
            back = std::max(back, norm(frame(state[0]).d1 - frame(begin[0]).d1) + norm(lane(state[0].spin, 0) - start));
        }
        std::printf("free top, a/b %.2f: error of the rate %.2e %.2e %.2e, ratios %.2f %.2f; angular momentum %.1e, "
                    "return %.1e\n",
                    ratio, error[0], error[1], error[2], error[0] / error[1], error[1] / error[2], momentum, back);
        EXPECT_LT(error[0], 1e-2);
        EXPECT_NEAR(std::log2(error[0] / error[1]), 2, 0.1);
        EXPECT_NEAR(std::log2(error[1] / error[2]), 2, 0.1);
        EXPECT_NEAR(std::log2(turned[1] / turned[2]), 2, 0.1);
        EXPECT_LE(momentum, 1e-12);
        EXPECT_LE(back, 1e-9);
    }
}

/// A free elliptic rod, bent, twisted and turning, until `time`.
struct Flight {
    std::vector<Slot<1>> end;
    double energy = 0, angular = 0, back = 0;
};
Flight fly(double ratio, double dt, double time) {
    SceneSpec scene;
    RodSpec rod = test::elliptic_rod(ratio, 20);
    rod.shape.start_curvature = Vec3d{0.8, 0.5, 1.0};
    rod.shape.velocity = {0.1, 0.2, -0.1};
    rod.shape.element_spin = {3, -2, 4};
    scene.rods = {rod};
    scene.time = {.duration = time, .dt = dt};
    test::Stage stage(scene, 1);
    const RodGroup& group = stage.groups[0];
    const auto start = stage.state(0);
    const test::Momenta before = test::momenta(group, start);
    Flight flight;
    const std::int64_t steps = stage.plan.steps;
    const double e0 = test::energy(group, start);
    for (int s = 1; s <= 100; ++s) {
        test::advance_checked(stage, steps * s / 100);
        const auto state = stage.state(0);
        flight.energy = std::max(flight.energy, std::abs(test::energy(group, state) / e0 - 1));
        flight.angular =
            std::max(flight.angular, norm(test::momenta(group, state).angular - before.angular) / norm(before.angular));
    }
    flight.end = stage.state(0);
    // Rates turned round, the same number of steps leads back to the start.
    auto state = flight.end;
    for (Slot<1>& s : state) {
        set_lane(s.velocity, 0, -lane(s.velocity, 0));
        set_lane(s.spin, 0, -lane(s.spin, 0));
    }
    stage.clock = Clock(dt, 0);
    stage.rods->import_rod(0, state);
    test::advance_checked(stage, steps);
    const auto returned = stage.state(0);
    for (std::size_t k = 0; k < start.size(); ++k) {
        flight.back = std::max(flight.back, norm(lane(returned[k].position, 0) - lane(start[k].position, 0)));
        if (k + 1 == start.size()) break;
        flight.back = std::max(flight.back, norm(frame(returned[k]).d1 - frame(start[k]).d1));
        flight.back = std::max(flight.back, norm(frame(returned[k]).d3 - frame(start[k]).d3));
    }
    return flight;
}

TEST(Elliptic, FreeRod) {
    for (const double ratio : {2.0, 4.0}) {
        const double dt[] = {5e-5, 2.5e-5, 1.25e-5, 6.25e-6};
        Flight flight[4];
        for (int i = 0; i < 4; ++i) flight[i] = fly(ratio, dt[i], 0.2);
        const auto apart = [&](int a, int b) {
            double most = 0;
            for (std::size_t k = 0; k < flight[a].end.size(); ++k)
                most = std::max(most, norm(lane(flight[a].end[k].position, 0) - lane(flight[b].end[k].position, 0)));
            return most;
        };
        const double first = std::log2(apart(0, 1) / apart(1, 2)), second = std::log2(apart(1, 2) / apart(2, 3));
        std::printf("elliptic rod, a/b %.0f: halving %.1e moves it by %.2e, orders %.2f %.2f; energy %.1e %.1e %.1e "
                    "%.1e; angular "
                    "momentum %.1e, return %.1e\n",
                    ratio, dt[0], apart(0, 1), first, second, flight[0].energy, flight[1].energy, flight[2].energy,
                    flight[3].energy, flight[0].angular, flight[0].back);
        EXPECT_NEAR(second, 2, 0.1);
        for (const Flight& f : flight) {
            EXPECT_LE(f.angular, 1e-12);
            EXPECT_LE(f.back, 1e-9);
        }
    }
}

} // namespace
} // namespace skein
