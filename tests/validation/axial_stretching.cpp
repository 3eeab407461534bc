// A rod stretched far beyond small strain (support/axial_stretching.hpp) against its integral, with the force in each
// element.
#include "support/axial_stretching.hpp"
#include "validation/study.hpp"

namespace skein {
namespace {

using namespace test::axial_stretching;

TEST(AxialStretching, LongStretchedRodMeetsItsIntegralAtSecondOrder) {
    test::ErrorTable table("axial_stretching");
    for (const long n : {10, 20, 40, 80}) {
        test::Stage stage(scene(n), 1);
        test::Cost cost;
        test::come_to_rest(stage, cost);
        constexpr Law law = Law::incompressible;
        const auto state = stage.state(0);
        double error = 0, force_error = 0;
        for (std::size_t k = 0; k < state.size(); ++k) {
            const double s = static_cast<double>(k) / static_cast<double>(n);
            error = std::max(error, std::abs(lane(state[k].position, 0).z - place(law, s)) / (place(law, 1) - 1));
            if (k == 0) continue;
            // The force of each element balances the load beyond it exactly: EA (e - 1)/e is the law to round-off.
            const double e = static_cast<double>(n) * (lane(state[k].position, 0).z - lane(state[k - 1].position, 0).z);
            const double beyond = end_load + load * (1 - s + 0.5 / static_cast<double>(n));
            force_error = std::max(force_error, std::abs(area * (e - 1) / e / beyond - 1));
        }
        EXPECT_LT(force_error, 1e-10);
        const double order = table.add("line", n, stage.plan.dt, error, cost);
        if (n > 10) {
            EXPECT_NEAR(order, 2.0, 0.05);
        }
    }
}

} // namespace
} // namespace skein
