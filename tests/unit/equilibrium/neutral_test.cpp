// Neutral motions by a sample of rows are those by all rows of the stiffness.
#include "equilibrium/newton.hpp"
#include "scene/scene_file.hpp"
#include "studies/scene_family.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

namespace skein {
namespace {

/// A round rod of length 1 m and bending stiffness 1.3e-6 N m^2, and a strip beside it.
SceneText rods(long elements, const char* start, const char* law, double force, const char* more = "") {
    return {"rods.toml",
            fmt::format(R"toml(
time.duration = 1.0
[[rods]]
name = "rod"
start = "{1}"
material = {{density = 1000.0, youngs_modulus = 1e9, law = "{2}"}}
section.radius = 2e-4
shape = {{length = 1.0, elements = {0}}}
placement = {{origin = [0.3, 0.1, 0.2], tangent = [1.0, 0.2, 0.0]}}
[[rods]]
name = "strip"
start = "clamped"
material = {{density = 1000.0, youngs_modulus = 1e9}}
section = {{kind = "rectangular", radius = 5e-4, radius_2 = 1e-4}}
shape = {{length = 0.5, elements = {0}}}
placement = {{origin = [0.0, 9.0, 0.0], tangent = [0.0, 0.0, 1.0]}}
[[load]]
kind = "formula"
at = "end"
force = ["0", "0", "{3}"]
{4}
)toml",
                        elements, start, law, force, more),
            {}};
}

/// Pieces and bodies that needed all rows.
int expect_same(const StaticCase& one, const StaticState& state, const std::string& name) {
    const StaticSystem::Balance balance = one.system->balance(state, true);
    const NeutralMotions all = one.system->neutral(state, balance, false), found = one.system->neutral(state, balance);
    EXPECT_EQ(found.count(), all.count()) << name;
    EXPECT_EQ(found.pieces.size(), all.pieces.size()) << name;
    for (std::size_t i = 0; i < std::min(found.pieces.size(), all.pieces.size()); ++i) {
        EXPECT_EQ(found.pieces[i].unknowns, all.pieces[i].unknowns) << name;
        EXPECT_EQ(found.pieces[i].motion, all.pieces[i].motion) << name;
    }
    return found.asked_in_full;
}

/// At the start, where the solution ends, and in states near it.
int expect_same(const SceneText& text, const std::string& name) {
    const auto one = static_case(text, {}, 1);
    StaticState state = start_of(*one->system, one->groups, one->rods);
    int asked = expect_same(*one, state, name + ", start");
    NewtonSolver(*one->system, {.stable = false}).find(state, 1); // where there is no equilibrium: not downhill
    asked += expect_same(*one, state, name + ", end");
    std::mt19937 random(1);
    for (const double size : {1e-9, 1e-6, 1e-3}) {
        std::uniform_real_distribution<double> some(-size, size);
        Unknown u(one->system->unknowns());
        for (double& x : u) x = some(random);
        StaticState near = state;
        one->system->correct(near, u, 1);
        one->system->refresh(near);
        expect_same(*one, near, fmt::format("{}, disturbed by {}", name, size));
    }
    return asked;
}

TEST(NeutralMotions, OfASampleAreThoseOfAllRows) {
    for (const char* law : {"incompressible", "linear", "elastica"})
        for (const double force : {0.0, 1e-12, 1e-9, 1e-6, 1e-5})
            for (const char* start : {"clamped", "pinned", "free"})
                for (const long n : {20, 100})
                    expect_same(rods(n, start, law, force), fmt::format("{} {}, {} N, n = {}", start, law, force, n));
}

TEST(NeutralMotions, OfLoadsThatHoldARod) {
    const char* const spring_bed = R"toml(
[[load]]
kind = "formula"
rods = ["rod"]
force = ["0", "0", "-1e-4*z"]
per = "length"
)toml";
    for (const char* start : {"pinned", "free"})
        expect_same(rods(100, start, "linear", 1e-9, spring_bed), std::string("bed, ") + start);
}

TEST(NeutralMotions, OfShippedScenes) {
    for (const auto& [file, number] : {std::pair{"statics/arc", "rods.0.shape.elements=80"},
                                       {"statics/bend_45", "rods.0.shape.elements=80"},
                                       {"statics/column", "rods.0.shape.elements=80"},
                                       {"statics/lee_frame", "rods.0.shape.elements=80"},
                                       {"statics/twist", "rods.0.shape.elements=80"},
                                       {"statics/twisted_ring", "rods.0.shape.elements=80"},
                                       {"statics/bistable_strip", "rods.0.shape.elements=80"},
                                       {"statics/magnetic_cilium", "rods.0.shape.elements=80"},
                                       {"recipes/cantilever", "rods.0.shape.elements=80"}}) {
        const std::string path = std::string(SHIPPED_SCENES) + "/" + file + ".toml";
        expect_same({path, read_scene_text(path), {number}}, file);
    }
}

TEST(NeutralMotions, OfAFreeRodAreItsRigidMotions) {
    const auto one = static_case(rods(10, "free", "linear", 0), {}, 1);
    const StaticState state = start_of(*one->system, one->groups, one->rods);
    const Eigen::MatrixXd stiffness(*one->system->balance(state, true).stiffness);
    const RodMotions all = one->system->motions_of_rods(state);
    ASSERT_EQ(all.first.size(), 3U);
    const int count = all.first[1];
    EXPECT_EQ(count, 63);
    const auto of_rod = stiffness.topLeftCorner(count, count);
    for (int m = 0; m < 6; ++m) {
        const Unknown motion = all.motion.col(m).head(count);
        EXPECT_GT(motion.norm(), 1) << m;
        EXPECT_LT((of_rod * motion).norm(), 1e-9 * of_rod.norm() * motion.norm()) << m;
    }
}

TEST(NeutralMotions, NeedASampleAloneWhereARodIsClamped) {
    for (const double force : {0.0, 1e-6, 1e-5}) {
        EXPECT_EQ(expect_same(rods(200, "clamped", "incompressible", force), "clamped"), 0) << force;
        EXPECT_EQ(expect_same(rods(200, "free", "incompressible", force), "free"), 2) << force; // not the strip
    }
}

} // namespace
} // namespace skein
