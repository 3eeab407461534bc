// A thin stretchable rod hung by both ends against the elastic catenary (support/catenary.hpp).
#include "support/catenary.hpp"
#include "validation/study.hpp"

namespace skein {
namespace {

using namespace test::catenary;

TEST(Catenary, HangingRodMeetsQuadratureAtSecondOrder) {
    const double tension = horizontal_tension(Law::incompressible);
    test::ErrorTable table("catenary");
    for (const long n : {10, 20, 40, 80}) {
        test::Stage stage(scene(n), 1);
        EXPECT_NEAR(norm(lane(stage.state(0).back().position, 0) - Vec3d{span, 0, 0}), 0, 1e-12)
            << "pinned where the span ends";
        test::Cost cost;
        test::come_to_rest(stage, cost);

        const auto exact = line(Law::incompressible, tension, n);
        const auto state = stage.state(0);
        double error = 0;
        for (std::size_t k = 0; k < state.size(); ++k)
            error = std::max(error, norm(lane(state[k].position, 0) - Vec3d{exact[k][0], 0, exact[k][1]}));
        const double order = table.add("line", n, stage.plan.dt, error, cost);
        if (n > 10) {
            EXPECT_NEAR(order, 2.0, 0.1);
        }
        if (n == 20) {
            EXPECT_LE(error, 1e-3);
        }
    }
}

} // namespace
} // namespace skein
