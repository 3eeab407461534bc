// Orders, Richardson values and error bars on numbers whose limit is known.
#include "skein/core/index.hpp"
#include "studies/convergence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace skein {
namespace {

constexpr double dt = 1e-3;

/// Runs of u(n, h) at ten samples; levels n, 2 n, 4 n from `first`, whose steps are dt over `shares`.
struct Runs {
    std::vector<double> values[4];
    LevelValues levels;

    Runs(const std::function<double(double n, double h, int sample)>& u, double first, std::size_t given = 0,
         std::array<int, 3> shares = {1, 2, 4}, int time_order = 2) {
        levels.given = given;
        levels.time_order = time_order;
        for (std::size_t k = 0; k < 3; ++k) {
            levels.dt[k] = dt / shares[k];
            for (int i = 0; i < 10; ++i) values[k].push_back(u(first * (1 << k), levels.dt[k], i));
            levels.space[k] = values[k];
        }
        for (int i = 0; i < 10; ++i) values[3].push_back(u(first * (1 << given), 0.5 * levels.dt[given], i));
        levels.half_step = values[3];
    }
};

double exact(int sample) { return 0.3 + std::sin(0.7 * sample); }

/// The largest error of the given run.
double error(const std::function<double(double, double, int)>& u, double n, double h) {
    double most = 0;
    for (int i = 0; i < 10; ++i) most = std::max(most, std::abs(u(n, h, i) - exact(i)));
    return most;
}

/// c/n^2 + d/n^4 in space, b h^2 in time, all different from sample to sample.
auto smooth(double c, double d, double b) {
    return [=](double n, double h, int i) {
        return exact(i) + (c / (n * n) + d / (n * n * n * n)) * std::cos(0.5 * i) + b * h * h * std::cos(0.9 * i);
    };
}

TEST(Convergence, BarHoldsTheErrorOfSmoothRuns) {
    for (const double d : {0.0, 30.0, -30.0, 100.0})
        for (const double b : {0.0, 1e3, -2e4, 3e4})
            for (const std::size_t given : {0u, 1u})
                for (const std::array<int, 3> shares :
                     {std::array{1, 1, 1}, std::array{1, 2, 4}, std::array{1, 1, 3}}) {
                    if (given == 1 && shares[1] != 1)
                        continue; // others have steps as long as the given one, or shorter
                    const auto u = smooth(2.0, d, b);
                    const Runs runs(u, 10, given, shares);
                    const Convergence c = converge(runs.levels);
                    const double n = given == 0 ? 10 : 20, true_error = error(u, n, dt);
                    EXPECT_EQ(c.smoothness, Smoothness::second);
                    EXPECT_NEAR(c.order, 2, 0.5);
                    EXPECT_GE(c.error_bar.total, true_error) << "d = " << d << ", b = " << b;
                    EXPECT_LE(c.error_bar.total, 2 * true_error) << "d = " << d << ", b = " << b;
                    EXPECT_GE(c.error_bar.space, error(u, n, 0));
                    EXPECT_GE(c.error_bar.time, std::abs(b) * dt * dt * (1 - 1e-9));
                    EXPECT_GE(c.error_bar_at_end.total, std::abs(u(n, dt, 9) - exact(9)));
                    double wrong = 0;
                    for (int i = 0; i < 10; ++i) wrong = std::max(wrong, std::abs(nth(c.limit, i) - exact(i)));
                    EXPECT_LE(wrong, c.remainder + 1e-12) << "the Richardson value";
                }
}

TEST(Convergence, RichardsonIsOfOrderFour) {
    double before = 0;
    for (const double n : {10.0, 20.0, 40.0}) {
        const Runs runs(smooth(2, 50, 0), n);
        const Convergence c = converge(runs.levels);
        const double wrong = std::abs(c.limit[0] - exact(0));
        if (before > 0) {
            EXPECT_NEAR(std::log2(before / wrong), 4, 0.1);
        }
        before = wrong;
    }
}

TEST(Convergence, FirstOrderIsTold) {
    const auto u = [](double n, double, int i) { return exact(i) + 0.5 / n * std::cos(0.5 * i); };
    const Convergence c = converge(Runs(u, 10).levels);
    EXPECT_EQ(c.smoothness, Smoothness::other);
    EXPECT_NEAR(c.order, 1, 1e-9);
    EXPECT_GE(c.error_bar.total, error(u, 10, dt));
    EXPECT_LE(c.error_bar.total, 3 * error(u, 10, dt));
}

TEST(Convergence, FirstOrderOfTheStep) {
    const auto u = [](double n, double h, int i) { return exact(i) + 1e-4 / (n * n) + 2 * h * std::cos(0.3 * i); };
    const Convergence c = converge(Runs(u, 10, 0, {1, 2, 4}, 1).levels);
    EXPECT_NEAR(c.error_bar.time, 1.5 * 2 * dt, 1e-9);
    EXPECT_EQ(c.smoothness, Smoothness::second) << "what the step does is taken out of what elements do";
    EXPECT_GE(c.error_bar.total, error(u, 10, dt));
}

TEST(Convergence, WhatIsNotSmoothHasABoundAndNoRichardsonValue) {
    const auto turning = [](double n, double, int i) { return exact(i) + (n < 15 ? 1e-3 : n < 25 ? -1e-3 : 5e-4); };
    const auto growing = [](double n, double, int i) { return exact(i) + 1e-6 * n * n; };
    const auto shaken = [](double n, double, int i) {
        std::mt19937 random(static_cast<unsigned>(n) * 100 + static_cast<unsigned>(i));
        return exact(i) + 1e-3 * std::normal_distribution()(random);
    };
    for (const std::function<double(double, double, int)>& u :
         {std::function<double(double, double, int)>(turning), {growing}, {shaken}}) {
        const Runs runs(u, 10);
        const Convergence c = converge(runs.levels);
        EXPECT_EQ(c.smoothness, Smoothness::rough);
        EXPECT_TRUE(c.limit.empty());
        EXPECT_EQ(c.spread, distance(runs.values[1], runs.values[2], 1));
        EXPECT_GE(c.error_bar.total, c.spread);
        EXPECT_GE(c.error_bar.total, distance(runs.values[0], runs.values[2], 1));
    }
}

TEST(Convergence, RoundOffIsNoOrder) {
    const auto u = [](double n, double, int i) { return exact(i) + 1e-15 * std::cos(n); };
    const Convergence c = converge(Runs(u, 10).levels);
    EXPECT_EQ(c.smoothness, Smoothness::exact);
    EXPECT_TRUE(std::isnan(c.order));
    EXPECT_LE(c.error_bar.total, 1e-13);
    const auto of_many_steps = [](double n, double, int i) { return exact(i) + 1e-11 * std::cos(n * n + 10 * i); };
    Runs runs(of_many_steps, 10);
    EXPECT_EQ(converge(runs.levels).smoothness, Smoothness::rough);
    runs.levels.steps = 1000000;
    EXPECT_EQ(converge(runs.levels).smoothness, Smoothness::exact) << "each step may add its round-off";
}

TEST(Convergence, PointsAreMeasuredByTheirDistance) {
    const std::vector<double> a = {0, 0, 0, 3, 4, 0}, b(6, 0.0);
    EXPECT_EQ(distance(a, b, 3), 5);
    EXPECT_EQ(distance(a, b, 1), 4);
}

/// Cost as of explicit steps whose limit falls with the length of elements.
CostModel model_cost() {
    CostModel cost;
    for (const double n : {10.0, 20.0, 40.0}) cost.levels.push_back({n, 0.01 / n, 1e-6 * n});
    return cost;
}

TEST(Cheapest, IsTheLeastThatMeetsTheTolerance) {
    const std::vector<ErrorModel> models = {{.space = 4e-3, .space_order = 2, .time = 1e-3, .time_order = 2},
                                            {.space = 1e-3, .space_order = 2, .time = 0, .time_order = 2}};
    const CostModel cost = model_cost();
    const auto choice = cheapest(models, 1e-3, 10, dt, cost, 1);
    ASSERT_TRUE(choice);
    const auto total = [&](long n, double step) { return models[0].at(static_cast<double>(n) / 10, step / dt); };
    EXPECT_LE(total(choice->elements, choice->dt), 1e-3 * (1 + 1e-9));
    EXPECT_LE(choice->dt, cost.dt_limit(static_cast<double>(choice->elements)) * (1 + 1e-9));
    // No other pair of numbers of a fine grid is cheaper.
    for (long n = 2; n < 200; ++n)
        for (double step = cost.dt_limit(static_cast<double>(n)); step > 1e-6; step *= 0.98)
            if (total(n, step) <= 1e-3) {
                EXPECT_GE(cost.core_seconds_per_step(static_cast<double>(n)) / step, choice->core_seconds * (1 - 1e-9));
            }
}

TEST(Cheapest, NoneWhereNoneWillDo) {
    const std::vector<ErrorModel> stuck = {{.space = 1, .space_order = 0.5, .time = 0, .time_order = 2}};
    EXPECT_FALSE(cheapest(stuck, 1e-3, 10, dt, model_cost(), 1));
}

TEST(Cheapest, FewerElementsWhereTheyDo) {
    const std::vector<ErrorModel> good = {{.space = 1e-5, .space_order = 2, .time = 1e-9, .time_order = 2}};
    const auto choice = cheapest(good, 1.01e-3, 40, 0.01 / 40, model_cost(), 1);
    ASSERT_TRUE(choice);
    EXPECT_EQ(choice->elements, 4) << "a hundred times the error, of second order: a tenth of the elements";
}

} // namespace
} // namespace skein
