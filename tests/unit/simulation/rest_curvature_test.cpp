// Rest curvature by formulas.
#include "scene/make_groups.hpp"
#include "scene/scene_refine.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

SceneSpec scene_of(std::vector<std::string> formulas, long elements) {
    SceneSpec scene = test::cilia_scene(1);
    RodSpec& rods = scene.rods[0];
    rods.shape.elements = elements;
    rods.shape.rest_curvature_formula = std::move(formulas);
    scene.constants = {{"a", 3.0, "1/m^2"}, {"k", 2.0, "1/m"}};
    return scene;
}

TEST(RestCurvature, OfAFormulaIsItsValueAtTheVertices) {
    SceneSpec scene = scene_of({"a*s", "k*sin(2*pi*s/L)", "0"}, 8);
    for (long k = 0; k < 8; ++k) scene.rods[0].shape.length_profile.push_back(1 + 0.1 * static_cast<double>(k));
    const auto groups = make_groups(scene);
    const double length = scene.rods[0].shape.length;
    double s = 0;
    for (std::size_t k = 0; k < groups[0].voronoi.size(); ++k) {
        s += groups[0].element[k].rest_length;
        EXPECT_NEAR(groups[0].voronoi[k].rest_curvature.x, 3 * s, 1e-14);
        EXPECT_NEAR(groups[0].voronoi[k].rest_curvature.y, 2 * std::sin(2 * M_PI * s / length), 1e-14);
        EXPECT_EQ(groups[0].voronoi[k].rest_curvature.z, 0);
    }
}

TEST(RestCurvature, OfAConstantIsThatOfTheNumber) {
    const auto written = make_groups(scene_of({"k", "0.5*k", "-1.5"}, 8));
    SceneSpec scene = scene_of({}, 8);
    scene.rods[0].shape.rest_curvature = {2, 1, -1.5};
    const auto named = make_groups(scene);
    for (std::size_t k = 0; k < named[0].voronoi.size(); ++k) {
        const Vec3d &a = written[0].voronoi[k].rest_curvature, &b = named[0].voronoi[k].rest_curvature;
        EXPECT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z);
    }
}

/// A curvature that grows along the rod is Euler's spiral: its end lies where Fresnel's integrals say.
TEST(RestCurvature, OfALineIsASpiralToSecondOrder) {
    const auto error = [](long n) {
        const SceneSpec scene = scene_of({"a*s", "0", "0"}, n);
        const double length = scene.rods[0].shape.length;
        double along = 0, across = 0;
        constexpr int parts = 2000; // middles
        for (int i = 0; i < parts; ++i) {
            const double s = (i + 0.5) * length / parts, angle = 1.5 * s * s;
            along += std::cos(angle) * length / parts;
            across += std::sin(angle) * length / parts;
        }
        const auto groups = make_groups(scene);
        std::vector<Slot<1>> state(static_cast<std::size_t>(groups[0].slots()));
        groups[0].start_state(0, state);
        const Vec3d way = lane(state.back().position, 0) - lane(state.front().position, 0);
        return std::abs(norm(way) - std::hypot(along, across));
    };
    const double coarse = error(16), fine = error(32);
    EXPECT_NEAR(std::log2(coarse / fine), 2, 0.15) << coarse << " " << fine;
}

TEST(RestCurvature, OfAFormulaIsWorkedOutAnewForOtherElements) {
    const SceneSpec scene = scene_of({"a*s", "0", "0"}, 6);
    const auto fine = make_groups(refined(scene, {2, 1}));
    ASSERT_EQ(fine[0].voronoi.size(), 11u);
    EXPECT_NEAR(fine[0].voronoi[0].rest_curvature.x, 3 * scene.rods[0].shape.length / 12, 1e-14);
}

} // namespace
} // namespace skein
