// Rods in two pieces that a fixed joint with stiffness = "auto" makes one, against the rod in one piece: under a pull,
// a shear, two bendings, a twist and muscles, with rest curvature, and by their first frequency. Then what has no whole
// to go by: unlike rods, rods at an angle, three in one place, one at an inner node, a body: the order, and the closed
// form where there is one.
#include "loads/end_couple.hpp"
#include "loads/end_force.hpp"
#include "loads/muscle_formula.hpp"
#include "loads/muscle_wave.hpp"
#include "skein/core/index.hpp"
#include "support/scenes_for_tests.hpp"
#include "validation/study.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

namespace skein {
namespace {

constexpr double length = 1, radius = 0.05, young = 1e6, density = 1000, area = std::numbers::pi * radius * radius,
                 bending = 0.25 * young * area * radius * radius;

RodSpec piece(const std::string& name, const Vec3d& from, const Vec3d& along, double size, long elements) {
    RodSpec rod = test::simple_rod(static_cast<int>(elements));
    rod.name = name;
    rod.material.youngs_modulus = young;
    rod.material.density = density;
    rod.section.radius = radius;
    rod.shape.length = size;
    rod.shape.elements = elements;
    rod.placement.origin = from;
    rod.placement.tangent = along;
    rod.placement.normal = Vec3d{0, 0, 1};
    return rod;
}

JointSpec joint(const std::string& a, const std::string& b, std::vector<double> at = {1, 0}) {
    return {.kind = JointKind::fixed, .between = {a, b}, .at = std::move(at)};
}

/// A rod of n elements, in as many pieces; the first is clamped.
SceneSpec in_pieces(long n, int pieces) {
    SceneSpec scene;
    for (int i = 0; i < pieces; ++i)
        scene.rods.push_back(
            piece("piece" + std::to_string(i), {length * i / pieces, 0, 0}, {1, 0, 0}, length / pieces, n / pieces));
    scene.rods[0].start = EndKind::clamped;
    for (int i = 1; i < pieces; ++i)
        scene.joints.push_back(joint(scene.rods[static_cast<std::size_t>(i) - 1].name, nth(scene.rods, i).name));
    return scene;
}

struct State {
    Vec3d tip, d1;
};
State at_rest(SceneSpec scene, std::size_t rod, double rate = 5, double duration = 12) {
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = rate}}};
    scene.time.duration = duration;
    test::Stage stage(scene);
    stage.advance(stage.plan.steps);
    const auto state = stage.state(rod);
    return {lane(state.back().position, 0), frame(state[state.size() - 2]).d1};
}
State at_rest(const SceneSpec& scene) { return at_rest(scene, scene.rods.size() - 1); }

void load_last(SceneSpec& scene, Load load) {
    scene.loads = {{.load = std::move(load), .rods = {scene.rods.back().name}}};
}

struct Case {
    std::string name;
    std::function<void(SceneSpec&)> load;
    std::function<double(const State&)> figure;
};
std::vector<Case> cases() {
    const auto x = [](const State& s) { return s.tip.x - length; };
    const auto y = [](const State& s) { return s.tip.y; };
    const auto z = [](const State& s) { return s.tip.z; };
    const double force = 0.3 * bending, couple = 0.5 * bending;
    return {
        {"pull",
         [](SceneSpec& s) {
             load_last(s, EndForce{.end = {0.01 * young * area, 0, 0}});
         },
         x},
        {"bending about one axis",
         [=](SceneSpec& s) {
             load_last(s, EndForce{.end = {0, force, 0}});
         },
         y},
        {"bending about the other",
         [=](SceneSpec& s) {
             load_last(s, EndForce{.end = {0, 0, force}});
         },
         z},
        {"couple",
         [=](SceneSpec& s) {
             load_last(s, EndCouple{.end = {0, couple, 0}});
         },
         z},
        {"twist",
         [=](SceneSpec& s) {
             load_last(s, EndCouple{.end = {couple, 0, 0}});
         },
         [](const State& s) { return s.d1.y; }},
        {"bent and pulled",
         [=](SceneSpec& s) {
             load_last(s, EndForce{.end = {0.05 * young * area, 0, 4 * force}});
         },
         z},
        {"muscle",
         [=](SceneSpec& s) {
             s.loads = {{.load = MuscleFormula{.moment = {"0.003 * (1 + s/L)", "0.002", "0"}}}};
             if (s.rods.size() == 2)
                 s.loads = {
                     {.load = MuscleFormula{.moment = {"0.003 * (1 + s/L/2)", "0.002", "0"}}, .rods = {"piece0"}},
                     {.load = MuscleFormula{.moment = {"0.003 * (1.5 + s/L/2)", "0.002", "0"}}, .rods = {"piece1"}}};
         },
         z},
        {"rest curvature",
         [](SceneSpec& s) {
             for (RodSpec& rod : s.rods) {
                 rod.shape.rest_curvature = {0.5, 0.2, 0.3};
                 rod.shape.start_curvature = Vec3d{0, 0, 0};
             }
         },
         z},
    };
}

TEST(JoinedRods, AreTheWholeRodUnderEveryLoad) {
    for (const Case& c : cases()) {
        const auto of = [&](long n, int pieces) {
            SceneSpec scene = in_pieces(n, pieces);
            c.load(scene);
            return c.figure(at_rest(scene));
        };
        const std::vector<long> counts{10, 20, 40};
        std::vector<double> whole, joined;
        for (const long n : counts) {
            whole.push_back(of(n, 1));
            joined.push_back(of(n, 2));
        }
        const double limit = (4 * whole[2] - whole[1]) / 3;
        std::printf("%s: whole %.8g\n", c.name.c_str(), limit);
        for (std::size_t i = 0; i < counts.size(); ++i) {
            const double own = std::abs(whole[i] - limit), off = std::abs(joined[i] - whole[i]);
            std::printf("  n = %ld: whole off by %.2e, joined from whole %.2e (relative)\n", counts[i],
                        own / std::abs(limit), off / std::abs(limit));
            EXPECT_LT(off, std::max(0.01 * own, 1e-9 * std::abs(limit))) << c.name << ", n = " << counts[i];
        }
    }
}

/// The frequency nearest to a guess, rad/s, at which a rod that is hit swings: where its transform in a window is
/// largest.
double frequency(SceneSpec scene, double guess) {
    for (RodSpec& rod : scene.rods) rod.shape.velocity = {0, 0, 1e-4};
    scene.time.duration = 15 * 2 * std::numbers::pi / guess;
    test::Stage stage(scene);
    const auto steps = static_cast<std::size_t>(stage.plan.steps);
    std::vector<double> tip;
    const std::int64_t every = 16;
    for (std::int64_t done = every; done <= stage.plan.steps; done += every) {
        stage.advance(done);
        tip.push_back(lane(stage.state(scene.rods.size() - 1).back().position, 0).z);
    }
    const double dt = stage.plan.dt * static_cast<double>(every), count = static_cast<double>(tip.size());
    const auto size = [&](double w) {
        std::complex<double> sum = 0;
        for (std::size_t i = 0; i < tip.size(); ++i) {
            const double t = (static_cast<double>(i) + 0.5) / count, p = 2 * std::numbers::pi * t;
            const double window =
                0.35875 - 0.48829 * std::cos(p) + 0.14128 * std::cos(2 * p) - 0.01168 * std::cos(3 * p);
            sum += window * tip[i] * std::polar(1.0, w * dt * static_cast<double>(i));
        }
        return std::abs(sum);
    };
    double low = 0.9 * guess, high = 1.1 * guess;
    for (int i = 0; i < 60; ++i) {
        const double a = low + 0.382 * (high - low), b = low + 0.618 * (high - low);
        (size(a) < size(b) ? low : high) = size(a) < size(b) ? a : b;
    }
    EXPECT_GT(steps, 0u);
    return 0.5 * (low + high);
}

TEST(JoinedRods, HaveTheFirstFrequencyOfTheWholeRodAndItsStep) {
    const double guess = 3.516 * std::sqrt(bending / (density * area)) / (length * length) * 0.99;
    std::vector<double> whole, joined;
    for (const long n : {10L, 20L, 40L}) {
        SceneSpec one = in_pieces(n, 1), two = in_pieces(n, 2);
        one.time.duration = two.time.duration = 1;
        whole.push_back(frequency(one, guess));
        joined.push_back(frequency(two, guess));
        const double step = test::Stage(two).plan.dt / test::Stage(one).plan.dt;
        std::printf("n = %ld: %.8f rad/s whole, %.8f joined; step %.4f of the whole's\n", n, whole.back(),
                    joined.back(), step);
        EXPECT_GT(step, 0.9);
    }
    const double limit = (4 * whole[2] - whole[1]) / 3;
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_LT(std::abs(joined[i] - whole[i]), 0.01 * std::abs(whole[i] - limit)) << i;
}

/// Figures at n, 2n and 4n; their order and what they tend to.
struct Trend {
    double order, limit;
};
Trend trend(const std::string& name, const std::function<double(long)>& of, long n = 10) {
    const double a = of(n), b = of(2 * n), c = of(4 * n);
    const Trend found{std::log2(std::abs((a - b) / (b - c))), c + (c - b) / 3};
    std::printf("%s: %.8g, %.8g, %.8g: order %.3f, tends to %.8g\n", name.c_str(), a, b, c, found.order, found.limit);
    return found;
}

TEST(JoinedRods, ThatAreUnlikeAreOfSecondOrder) {
    const double thin = 0.035, second = 0.4, first = 0.6, force = 1e-4 * bending;
    const auto of = [&](long n) {
        SceneSpec scene;
        scene.rods = {piece("thick", {0, 0, 0}, {1, 0, 0}, first, n / 2),
                      piece("thin", {first, 0, 0}, {1, 0, 0}, second, n / 2)};
        scene.rods[0].start = EndKind::clamped;
        scene.rods[1].section.radius = thin;
        scene.joints = {joint("thick", "thin")};
        load_last(scene, EndForce{.end = {0, 0, force}});
        return at_rest(scene).tip.z;
    };
    const Trend found = trend("unlike rods", of);
    EXPECT_NEAR(found.order, 2, 0.1);
    const double share = std::pow(thin / radius, 4);
    const auto shear = [](double r) { return 27.0 / 28 * young / 3 * std::numbers::pi * r * r; };
    const double bent =
        force / bending * ((std::pow(length, 3) - std::pow(second, 3)) / 3 + std::pow(second, 3) / (3 * share)) +
        force * (first / shear(radius) + second / shear(thin));
    EXPECT_NEAR(found.limit / bent, 1, 1e-5);
}

/// Two rods at a right angle, the first along x and clamped, the second along y.
SceneSpec bracket(long n) {
    SceneSpec scene;
    scene.rods = {piece("first", {0, 0, 0}, {1, 0, 0}, 0.5, n / 2),
                  piece("second", {0.5, 0, 0}, {0, 1, 0}, 0.5, n / 2)};
    scene.rods[0].start = EndKind::clamped;
    scene.joints = {joint("first", "second")};
    return scene;
}

TEST(JoinedRods, AtAnAngleAreOfSecondOrder) {
    const double force = 0.2 * bending;
    const auto of = [&](const Vec3d& direction) {
        return [&, direction](long n) {
            SceneSpec scene = bracket(n);
            load_last(scene, EndForce{.end = force * direction});
            const Vec3d tip = at_rest(scene).tip - Vec3d{0.5, 0.5, 0};
            return dot(direction, tip);
        };
    };
    for (const auto& [name, direction] : {std::pair("out of the plane", Vec3d{0, 0, 1}),
                                          {"in the plane, along x", {1, 0, 0}},
                                          {"in the plane, along y", {0, 1, 0}},
                                          {"askew", {0.6, 0, 0.8}}})
        EXPECT_NEAR(trend(std::string("a bracket, ") + name, of(direction)).order, 2, 0.15) << name;
}

TEST(JoinedRods, ThreeInOnePlaceAreOfSecondOrder) {
    const auto of = [&](long n) {
        SceneSpec scene = bracket(n);
        scene.rods.push_back(piece("third", {0.5, 0, 0}, {0, -0.6, 0.8}, 0.5, n / 2));
        scene.joints.push_back(joint("first", "third"));
        scene.loads = {{.load = EndForce{.end = {0, 0, 0.1 * bending}}, .rods = {"third"}},
                       {.load = EndForce{.end = {0.1 * bending, 0, 0}}, .rods = {"second"}}};
        return at_rest(scene).tip.z;
    };
    EXPECT_NEAR(trend("three rods", of).order, 2, 0.15);
}

TEST(JoinedRods, AtAnInnerNodeAreOfSecondOrder) {
    const auto of = [&](long n) {
        SceneSpec scene;
        scene.rods = {piece("beam", {0, 0, 0}, {1, 0, 0}, 1, n), piece("arm", {0.5, 0, 0}, {0, 1, 0}, 0.5, n / 2)};
        scene.rods[0].start = EndKind::clamped;
        scene.joints = {joint("beam", "arm", {0.5, 0})};
        load_last(scene, EndForce{.end = {0.05 * bending, 0, 0.1 * bending}});
        return at_rest(scene).tip.z;
    };
    EXPECT_NEAR(trend("an arm at an inner node", of).order, 2, 0.15);
}

TEST(JoinedRods, WithABodyAreOfSecondOrder) {
    const double mass = 2, weight = 0.05 * bending, arm = 0.1;
    const auto of = [&](long n) {
        SceneSpec scene;
        RodSpec ball = test::rigid_body(0, arm);
        ball.name = "ball";
        ball.placement.origin = {length + arm, 0, 0};
        ball.body->mass = mass;
        ball.body->inertia = {0.02, 0.02, 0.02};
        scene.rods = {piece("rod", {0, 0, 0}, {1, 0, 0}, length, n), ball};
        scene.rods[0].start = EndKind::clamped;
        scene.joints = {joint("rod", "ball")};
        scene.loads = {{.load = EndForce{.end = {0, 0, weight}}, .rods = {"rod"}}};
        return at_rest(scene, 0).tip.z;
    };
    EXPECT_NEAR(trend("a ball at the tip", of).order, 2, 0.15);
}

TEST(JoinedRods, BendWithMusclesInOneOfThem) {
    const double k = 0.01, half = length / 2, expected = (1 - std::cos(k * half)) / k + half * std::sin(k * half);
    for (const long n : {10L, 20L, 40L}) {
        SceneSpec scene = in_pieces(n, 2);
        const std::string moment = fmt::format("{:.17g}", -k * bending);
        scene.loads = {{.load = MuscleFormula{.moment = {"0", moment, "0"}}, .rods = {"piece0"}}};
        const double found = std::abs(at_rest(scene).tip.z);
        std::printf("a muscle in the first half, n = %ld: %.8g of the closed form\n", n, found / expected);
        EXPECT_NEAR(found / expected, 1, 1e-5) << n;
    }
}

} // namespace
} // namespace skein
