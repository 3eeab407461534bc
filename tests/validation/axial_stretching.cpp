// A rod held at its top, stretched by its own load and by a force on its end, far beyond small strain.
//   T(s) = F + q (L - s) = E A (e - 1)/e,   x(s) = integral of ds/(1 - T/(E A))
//        = (E A/q) ln[(E A - F - q (L - s))/(E A - F - q L)]
#include "validation/study.hpp"

#include <numbers>

namespace skein {
namespace {

constexpr double radius = 0.1, area = std::numbers::pi * radius * radius; // L = rho = E = 1
constexpr double load = 0.3 * area, end_load = 0.15 * area;               // q L and F, N

double place(double s) { return area / load * std::log((area - end_load - load * (1 - s)) / (area - end_load - load)); }

TEST(AxialStretching, LongStretchedRodMeetsItsIntegralAtSecondOrder) {
    test::ErrorTable table("axial_stretching");
    for (const long n : {10, 20, 40, 80}) {
        const RodSpec rod = test::clamped_unit_rod(n, radius);
        const double omega =
            0.5 * std::numbers::pi * (1 - (end_load + load) / area); // of the first axial wave, slower by the largest stretch
        test::Stage stage(test::coming_to_rest(rod, omega,
                                               {{.load = UniformForce{.force = {0, 0, load}, .ramp = 2 / omega}},
                                                {.load = EndForce{.end = {0, 0, end_load}, .ramp = 2 / omega}}}),
                          1);
        test::Cost cost;
        test::come_to_rest(stage, omega, cost);
        const auto state = stage.state(0);
        double error = 0, force_error = 0;
        for (std::size_t k = 0; k < state.size(); ++k) {
            const double s = static_cast<double>(k) / static_cast<double>(n);
            error = std::max(error, std::abs(lane(state[k].position, 0).z - place(s)) / (place(1) - 1));
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
