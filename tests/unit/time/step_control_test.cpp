// Parts of steps by error, on small systems whose motion is known.
#include "time/step_control.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

namespace skein {
namespace {

using State = std::array<double, 2>; // place, rate
using Force = std::function<double(double place, double rate, double time)>;

/// Explicit midpoint parts: second order, as those of rods.
State advance(const Force& force, State s, double begin, double dt, std::int64_t parts) {
    const double h = dt / static_cast<double>(parts);
    for (std::int64_t i = 0; i < parts; ++i) {
        const double t = begin + static_cast<double>(i) * h;
        const double x = s[0] + h / 2 * s[1], v = s[1] + h / 2 * force(s[0], s[1], t);
        s = {s[0] + h * v, s[1] + h * force(x, v, t + h / 2)};
    }
    return s;
}

struct Result {
    double error = 0, told = 0; ///< largest true error, and the one that the control tells
    double parts = 0;           ///< of all steps
};

/// As World::step_by_error, for steps of a whole run.
Result run(const Force& force, State at, double duration, int steps, double tolerance) {
    StepControl control(tolerance, steps);
    State companion = at, exact = at;
    const double dt = duration / steps;
    Result result;
    for (int n = 0; n < steps; ++n) {
        const double t = n * dt;
        std::optional<State> half;
        while (true) {
            const std::int64_t p = control.parts();
            const State end = advance(force, at, t, dt, p), other = advance(force, companion, t, dt, p / 2);
            const double distance = std::abs(end[0] - other[0]);
            const double change = std::abs(end[0] - other[0] - (at[0] - companion[0]));
            const bool compares = half || !control.trusts(change);
            if (compares && !half) half = advance(force, at, t, dt, p / 2);
            const double local = compares ? std::abs(end[0] - (*half)[0]) : 0;
            if (!compares || control.allows(local)) {
                if (compares) control.note_compared(local, distance, change);
                else control.note_trusted(distance, change);
                at = end;
                companion = other;
                result.parts += static_cast<double>(p);
                break;
            }
            half = end;
            if (!control.refine()) return result;
        }
        exact = advance(force, exact, t, dt, 4096);
        result.error = std::max(result.error, std::abs(at[0] - exact[0]));
    }
    result.told = control.most();
    return result;
}

struct Scene {
    const char* name;
    Force force;
    State start;
};

const Scene scenes[] = {
    {"oscillator", [](double x, double, double) { return -40 * x; }, {1, 0}},
    {"damped", [](double x, double v, double) { return -400 * x - 4 * v; }, {1, 0}},
    {"driven in flight", [](double, double, double t) { return std::sin(9 * t); }, {0, 1}},
    {"flight with drag", [](double, double v, double) { return -v * std::abs(v); }, {0, 3}},
    {"pushed once", [](double, double, double t) { return 50 * std::exp(-std::pow((t - 0.32) / 0.03, 2)); }, {0, 0}},
    {"pendulum", [](double x, double, double) { return -30 * std::sin(x); }, {2.5, 0}},
};
/// Its errors grow a hundredfold after they are made.
const Scene unstable = {"falls over", [](double x, double, double) { return 9 * std::sin(x); }, {1e-2, 0}};

TEST(StepControl, KeepsTheToleranceOfPlacesAndTellsIt) {
    for (const Scene& scene : scenes)
        for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
            const Result result = run(scene.force, scene.start, 2.0, 64, tolerance);
            EXPECT_LE(result.error, tolerance) << scene.name << " " << tolerance;
            EXPECT_LE(result.error, result.told * 1.1) << scene.name << " " << tolerance;
        }
}

TEST(StepControl, TellsErrorsThatGrow) {
    for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
        const Result result = run(unstable.force, unstable.start, 2.0, 64, tolerance);
        EXPECT_LE(result.error, 4 * tolerance);
        EXPECT_LE(result.error, result.told * 1.1);
    }
}

/// What is forgotten may be wrong for a while: parts go by the error that lasts.
TEST(StepControl, TakesFewerPartsWhereErrorsDecay) {
    const Force lasting = [](double, double, double t) { return 30 * std::sin(40 * t); };
    const Force forgotten = [&](double x, double v, double t) { return lasting(x, v, t) - 40 * v - 400 * x; };
    const Result a = run(lasting, {0, 0}, 4.0, 256, 1e-4), b = run(forgotten, {0, 0}, 4.0, 256, 1e-4);
    EXPECT_LE(b.error, 1e-4);
    EXPECT_LT(2 * b.parts, a.parts);
}

TEST(StepControl, EndsAtTheMostParts) {
    StepControl control(1e-3, 10);
    while (control.parts() < StepControl::most_parts) ASSERT_TRUE(control.refine());
    EXPECT_FALSE(control.refine());
}

TEST(StepControl, GoesOnFromItsNumbers) {
    StepControl one(1e-3, 20);
    for (int n = 0; n < 7; ++n) {
        if (n == 2) ASSERT_TRUE(one.refine());
        if (n % 2 == 0) one.note_compared(1e-6 * n, 2e-6 * n, 3e-6);
        else one.note_trusted(1e-6 * n, 2e-6);
    }
    StepControl other(1e-3, 20);
    other.set(one.numbers());
    EXPECT_EQ(other.parts(), one.parts());
    EXPECT_EQ(other.allowed(), one.allowed());
    for (int n = 0; n < 9; ++n)
        for (StepControl* control : {&one, &other}) control->note_trusted(1e-5 * n, 1e-6);
    EXPECT_EQ(other.numbers(), one.numbers());
    EXPECT_EQ(other.allowed(), one.allowed());
}

TEST(StepControl, WithoutAToleranceFallsBackToWholeSteps) {
    StepControl control(0);
    EXPECT_FALSE(control.limited());
    ASSERT_TRUE(control.refine());
    EXPECT_EQ(control.parts(), 2);
    control.note();
    EXPECT_EQ(control.parts(), 1);
    control.note();
    EXPECT_EQ(control.parts(), 1);
}

TEST(StepControl, MakesNoFewerPartsThanDrivesNeed) {
    StepControl control(1e-3, 10, StepControl::most_parts, 5);
    for (int step = 0; step < 4; ++step) {
        EXPECT_EQ(control.parts(), 8);
        control.note_compared(0, 0, 0); // no error: half as many would do
    }
    EXPECT_EQ(StepControl(0, 10, StepControl::most_parts, 5).parts(), 1) << "a given step stays";
}

TEST(StepControl, NamesWhatStopsIt) {
    StepControl control(0);
    control.limit(2);
    EXPECT_TRUE(control.can_refine());
    ASSERT_TRUE(control.refine());
    EXPECT_FALSE(control.can_refine());
    control.note_obstacle(StepControl::Obstacle::contact);
    EXPECT_FALSE(control.refine());
    EXPECT_EQ(control.obstacle(), StepControl::Obstacle::contact);
}

} // namespace
} // namespace skein
