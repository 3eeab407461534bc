// Large rotations in three dimensions, at rest, against their boundary-value problem (support/large_rotation.hpp). Two
// resolutions make a Richardson value (4 u_2n - u_n)/3, of fourth order in the plane. The bend also twists, and keeps a
// small term of third order: the wall's moment is resolved in the frame of the half cell's middle.
//
// The published tips have six digits. Those of the linear law are met; those of the incompressible law are 3e-6 and
// 5e-6 away from this continuum, to which Richardson values converge.
#include "support/large_rotation.hpp"
#include "validation/study.hpp"

namespace skein {
namespace {

using namespace test::large_rotation;

struct Case {
    const char* name;
    Law law;
    TipLoad load;
    Vec3d published; ///< tip
    double published_error;
};
constexpr Case cases[] = {
    {"straight", Law::incompressible, straight, {0.653364, 0.196009, 0.658350}, 6e-6},
    {"straight, linear", Law::linear, straight, {0.651861, 0.195558, 0.659299}, 1e-6},
    {"bend", Law::incompressible, bend, {0.688783, 0.348759, 0.492498}, 6e-6},
    {"bend, linear", Law::linear, bend, {0.687119, 0.348947, 0.493535}, 1e-6},
};

Vec3d measured_tip(const Case& c, long n, double& dt, test::Cost& cost) {
    SceneSpec scene = test::large_rotation::scene(c.load, n);
    scene.rods[0].material.law = c.law;
    test::Stage stage(scene, 1);
    dt = stage.plan.dt;
    test::come_to_rest(stage, cost);
    return lane(stage.state(0).back().position, 0);
}

TEST(LargeRotation, TipsMeetBoundaryValueProblemAndRichardsonIsFourthOrder) {
    test::ErrorTable table("large_rotation");
    for (const Case& c : cases) {
        const std::string name = c.name;
        const Vec3d exact = tip(c.law, c.load);
        EXPECT_LT(norm(shoot(c.law, c.load, bending * c.load.force, exact) - exact), 1e-11) << name;
        std::printf("%s: exact tip (%.8f, %.8f, %.8f)\n", c.name, exact.x, exact.y, exact.z);
        for (const double off : {exact.x - c.published.x, exact.y - c.published.y, exact.z - c.published.z})
            EXPECT_LE(std::abs(off), c.published_error) << name;

        Vec3d coarse{}, extrapolated{};
        test::Cost coarse_cost;
        for (const long n : {5, 10, 20, 40, 80}) {
            double dt = 0;
            test::Cost cost;
            const Vec3d fine = measured_tip(c, n, dt, cost);
            const double order = table.add(name, n, dt, norm(fine - exact), cost);
            if (n >= 20) {
                EXPECT_NEAR(order, 2.0, 0.1) << name << ", n = " << n;
            }
            if (n > 5) {
                extrapolated = (4.0 / 3) * fine - (1.0 / 3) * coarse;
                const test::Cost both{cost.element_steps + coarse_cost.element_steps,
                                      cost.seconds + coarse_cost.seconds};
                const double order_4 = table.add(name + " Richardson", n, dt, norm(extrapolated - exact), both);
                if (n == 80) {
                    EXPECT_NEAR(order_4, norm(c.load.rest_curvature) > 0 ? 3.0 : 4.0, 0.2) << name;
                }
            }
            coarse = fine;
            coarse_cost = cost;
        }
        EXPECT_LE(norm(extrapolated - exact), 1e-6) << name;
    }
}

} // namespace
} // namespace skein
