// Errors to expect of bodies that a fluid does not resolve, against those that were measured (apps/flow/README.md).
#include "physics/fluid/fluid_doubts.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

TEST(FluidDoubts, ExpectTheDragThatWasMeasured) {
    struct Measured {
        double radius, diameters;
        bool on_axis;
        double error;
    };
    for (const Measured& m : {Measured{0.8, 20, true, -0.009},
                              {0.95, 20, true, -0.05},
                              {1, 10, false, 0.087},
                              {1.5, 10, false, 0.061},
                              {2, 10, false, 0.028},
                              {3, 10, false, 0.003}})
        EXPECT_NEAR(drag_error(m.radius, 2 * m.radius * m.diameters, m.on_axis), m.error, 0.015) << m.radius;
    EXPECT_NEAR(drag_error(0.096, 24, true), 0.59, 0.02);
    EXPECT_TRUE(std::isnan(drag_error(1.5, 3, false))) << "a body that is not slender";
}

TEST(FluidDoubts, NameEachBodyOfLessThanTwoCellsInRadius) {
    FluidPlan fluid;
    fluid.constants.grid = {.cells = {40, 40, 1}, .h = 0.1};
    fluid.obstacles = {{.name = "thick", .radius = 0.2},
                       {.name = "thin", .radius = 0.19},
                       {.name = "flat", .kind = ObstacleKind::cylinder, .radius = 0.5, .second_radius = 0.1}};
    std::vector<RodGroup> groups;
    for (const double radius : {0.2, 0.15, 0.0096}) {
        RodSpec spec;
        spec.name = "rods" + std::to_string(groups.size());
        spec.material = {.density = 1, .youngs_modulus = 1};
        spec.section.radius = radius;
        spec.shape.length = 2.4;
        spec.shape.elements = 20;
        groups.emplace_back(spec, static_cast<int>(groups.size()), 0, ".");
        RodsInFluid rods{.name = spec.name, .least_axis = radius / 0.1, .most_axis = radius / 0.1};
        nth(rods.has, radius < 0.1 ? SectionMarkers::centre_line : SectionMarkers::ring) = true;
        fluid.rods.push_back(rods);
    }
    const std::vector<std::string> found = fluid_doubts(fluid, groups);
    ASSERT_EQ(found.size(), 4u);
    EXPECT_NE(found[0].find("rods.rods1: 1.5 cells in radius"), std::string::npos) << found[0];
    EXPECT_NE(found[1].find("rods.rods2: 0.096 cells in radius"), std::string::npos) << found[1];
    EXPECT_NE(found[1].find("about 1.6 times its own"), std::string::npos) << found[1];
    EXPECT_NE(found[1].find("fluid.spacing = 0.0123"), std::string::npos) << found[1];
    EXPECT_NE(found[2].find("obstacle 'thin': 1.9 cells"), std::string::npos) << found[2];
    EXPECT_NE(found[3].find("obstacle 'flat': 1 cells in half the thickness"), std::string::npos) << found[3];
}

} // namespace
} // namespace skein
