// A cantilever that is cut in two and joined by a fixed joint, under a force on its tip. The joint bends by M/k_t and
// shifts by F/k, so with stiffness the deflection tends to that of halves in one piece. Those have no cell between
// their elements at the cut: they bend as if that half-length on both sides were stiff, by a share that falls with the
// element length. Where the joint has the stiffness of the missing cell, EI/l, the deflection is that of the whole rod.
#include "loads/end_force.hpp"
#include "support/scenes_for_tests.hpp"
#include "validation/study.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skein {
namespace {

constexpr double length = 1, radius = 0.05, young = 1e6, force = 1e-3;
constexpr double bending = young * 0.25 * std::numbers::pi * radius * radius * radius * radius;

RodSpec piece(const std::string& name, double from, double size, long elements) {
    RodSpec rod = test::simple_rod(static_cast<int>(elements));
    rod.name = name;
    rod.material.youngs_modulus = young;
    rod.material.density = 1000;
    rod.section.radius = radius;
    rod.shape.length = size;
    rod.shape.elements = elements;
    rod.placement.origin = {from, 0, 0};
    rod.placement.tangent = {1, 0, 0};
    return rod;
}

double deflection(SceneSpec scene, std::size_t last) {
    scene.loads = {{.load = EndForce{.end = {0, 0, force}}, .rods = {scene.rods[last].name}}};
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 5}}};
    scene.time.duration = 15;
    test::Stage stage(scene);
    stage.advance(stage.plan.steps);
    return lane(stage.state(last).back().position, 0).z;
}

double whole(long elements) {
    SceneSpec scene;
    scene.rods = {piece("whole", 0, length, elements)};
    scene.rods[0].start = EndKind::clamped;
    return deflection(scene, 0);
}

double joined(long elements, double stiffness, double torsional_stiffness) {
    SceneSpec scene;
    scene.rods = {piece("first", 0, 0.5 * length, elements / 2),
                  piece("second", 0.5 * length, 0.5 * length, elements / 2)};
    scene.rods[0].start = EndKind::clamped;
    scene.joints = {{.kind = JointKind::fixed,
                     .between = {"first", "second"},
                     .law = {.stiffness = stiffness, .torsional_stiffness = torsional_stiffness}}};
    return deflection(scene, 1);
}

TEST(JoinedCantilever, TendsToTheWholeOne) {
    const long n = 20;
    const auto of_joint = [](double k, double turning) { return force / k + force * 0.25 * length * length / turning; };
    const double one = whole(n), limit = joined(n, 1e7, 1e4) - of_joint(1e7, 1e4);
    double before = 0;
    for (const double share : {1.0, 10.0, 100.0}) {
        const double k = 1e4 * share, turning = 10 * bending / length * share, more = joined(n, k, turning) - limit;
        std::printf("k = %g N/m, k_t = %g N m/rad: %.5f of the whole rod's deflection\n", k, turning,
                    (limit + more) / one);
        EXPECT_NEAR(more, of_joint(k, turning), 1e-3 * more) << k;
        if (before > 0) {
            EXPECT_NEAR(more / before, 0.1, 1e-3);
        }
        before = more;
    }
    std::printf("limit: %.5f\n", limit / one);
}

TEST(JoinedCantilever, LacksTheCellAtTheCutByFirstOrder) {
    double before = 0;
    for (const long n : {10, 20, 40}) {
        const double lack = 1 - joined(n, 1e7, 1e4) / whole(n), expected = 0.75 * length / static_cast<double>(n);
        std::printf("n = %ld: stiffer by %.4f, expected %.4f\n", n, lack, expected);
        EXPECT_NEAR(lack, expected, 0.15 * expected); // M^2 l/(2 E I) in the middle over F w/2, without shear
        if (before > 0) {
            EXPECT_NEAR(before / lack, 2, 0.15);
        }
        before = lack;
    }
}

TEST(JoinedCantilever, IsTheWholeOneWhereTheJointIsTheMissingCell) {
    const long n = 20;
    const double one = whole(n), found = joined(n, 1e8, bending * n / length);
    EXPECT_NEAR(found / one, 1, 2e-3);
}

} // namespace
} // namespace skein
