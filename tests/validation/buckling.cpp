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

} // namespace
} // namespace skein
