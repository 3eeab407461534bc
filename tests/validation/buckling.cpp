// The critical load of a clamped rod (support/euler_buckling.hpp) against its closed form.
#include "support/euler_buckling.hpp"
#include "validation/study.hpp"

namespace skein {
namespace {

using namespace test::euler_buckling;

TEST(Buckling, CriticalLoadMeetsClosedFormAtSecondOrder) {
    const double exact = critical_load(Law::incompressible);
    EXPECT_NEAR(exact / euler, 1, 1e-2) << "a slender rod: near Euler's load";
    test::ErrorTable table("euler_buckling");
    for (const long n : {10, 20, 40, 80}) {
        double dt = 0;
        test::Cost cost;
        const double load = measured_load(
            n, exact, cost, [](SceneSpec scene) { return test::Stage(std::move(scene), 1); },
            [&](const test::Stage& stage, double width, double below, double above) {
                dt = stage.plan.dt;
                EXPECT_GT(below, 0) << "stands at " << 1 - width << " of the load";
                EXPECT_LT(above, 0) << "buckles at " << 1 + width << " of the load";
            });
        const double order = table.add("critical load", n, dt, std::abs(load / exact - 1), cost);
        if (n > 10) {
            EXPECT_NEAR(order, 2.0, 0.1);
        }
        if (n == 20) {
            EXPECT_LE(std::abs(load / exact - 1), 1e-3);
        }
    }
}

// Half cells at ends that slide: the error is the (k l)^2/12 of the cells along the rod, and nothing is left of the
// ends'.
TEST(Buckling, GuidedAndSlidingClampsAreOfSecondOrder) {
    test::ErrorTable table("buckling_sliding");
    for (const auto& [column, bar] : {std::pair{guided, 2.5e-3}, {sliding, 9e-3}}) {
        const double exact = critical_load(Law::incompressible, column);
        double loads[2] = {};
        for (const long n : {10, 20, 40}) {
            double dt = 0;
            test::Cost cost;
            const double load = measured_load(
                n, exact, cost, [](SceneSpec scene) { return test::Stage(std::move(scene), 1); },
                [&](const test::Stage& stage, double, double, double) { dt = stage.plan.dt; }, column);
            const double error = 1 - load / exact, order = table.add(column.name, n, dt, std::abs(error), cost);
            const double cell = column.wave_number / static_cast<double>(n);
            EXPECT_NEAR(error, cell * cell / 12, 0.1 * cell * cell / 12) << column.name << ", n = " << n;
            if (n > 10) {
                EXPECT_GE(order, 1.9) << column.name;
            }
            if (n == 20) {
                EXPECT_LE(std::abs(error), bar) << column.name;
            }
            if (n <= 20) loads[n / 20] = load;
        }
        EXPECT_NEAR((4 * loads[1] - loads[0]) / 3 / exact, 1, 3e-4) << column.name << ", Richardson's of n = 10 and 20";
    }
}

} // namespace
} // namespace skein
