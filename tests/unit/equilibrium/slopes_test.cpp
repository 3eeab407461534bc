// Numbers that are set in a scene beside those that are read, and adjoint solutions beside solutions.
#include "equilibrium/static_solution.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"
#include "studies/scene_family.hpp"
#include "studies/scene_number.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

namespace skein {
namespace {

/// A rod of length 1 with a rest curvature by a table, under a force on its tip.
SceneText rod(long elements, const char* start) {
    return {"rod.toml",
            fmt::format(R"toml(
time.duration = 1.0
constants.pull = {{value = 0.25, unit = "N"}}
[[table]]
name = "bend"
at = [0.0, 0.5, 1.0]
at_unit = "m"
value = [0.0, 0.0, 0.0]
[[rods]]
name = "rod"
start = "{}"
material = {{density = 1000.0, youngs_modulus = 1e9}}
section.radius = 2e-4
shape = {{length = 1.0, elements = {}, rest_curvature_formula = ["bend(s)", "0", "0"], start_curvature = [0.0, 0.0, 0.0]}}
placement = {{origin = [0.0, 0.0, 0.0], tangent = [1.0, 0.0, 0.0]}}
[[bodies]]
name = "ball"
density = 500.0
spheres.radii = [0.01]
placement.origin = [0.0, 9.0, 0.0]
[[load]]
kind = "end_force"
rods = ["rod"]
end = [0.0, 0.0, 1e-9]
[[probe]]
name = "tip"
of = "rod"
)toml",
                        start, elements),
            {}};
}

TEST(SceneNumber, IsSetAsAnOverrideSetsIt) {
    const SceneText text = rod(8, "clamped");
    const SceneSpec scene = parse_scene(text.file, text.text);
    for (const std::string key : {"rods.rod.material.youngs_modulus", "rods.0.placement.origin.2", "table.bend.value.1",
                                  "load.0.end.1", "load.end_force.end.2", "rods.rod.shape.start_curvature.0",
                                  "constants.pull.value", "time.duration", "bodies.ball.density", "probe.tip.at"}) {
        const SceneSpec expected = parse_scene(text.file, text.text, {key + "=0.75"});
        EXPECT_EQ(scene_json(with_number(scene, key, 0.75), false), scene_json(expected, false)) << key;
        EXPECT_EQ(number_at(expected, key).value, 0.75) << key;
    }
    EXPECT_THROW(with_number(scene, "rods.rod.material.youngs_modulus", -1), InputError);
    for (const char* key :
         {"rods.bar.material.density", "load.0.end.3", "table.bend.value.3", "table.bend", "probe.1.at"})
        EXPECT_THROW(with_number(scene, key, 0.75), InputError) << key;
}

TEST(StaticSolution, AdjointIsTheTranspose) {
    for (const char* start : {"clamped", "pinned", "free"}) {
        const auto one = static_case(rod(6, start), {}, 1);
        const StaticState state = start_of(*one->system, one->groups, one->rods);
        StaticSystem::Balance balance = one->system->balance(state, true);
        const StaticSolution solution(*one->system, state, balance);
        std::mt19937_64 bits(7);
        std::normal_distribution<double> normal;
        Unknown a(one->system->unknowns()), b(a.size());
        for (Eigen::Index i = 0; i < a.size(); ++i) {
            a[i] = normal(bits);
            b[i] = normal(bits);
        }
        const double expected = a.dot(solution.solve(b));
        EXPECT_NEAR(solution.adjoint(a).dot(b), expected, 1e-9 * a.norm() * solution.solve(b).norm()) << start;
    }
}

} // namespace
} // namespace skein
