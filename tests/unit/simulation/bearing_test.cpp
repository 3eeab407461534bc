// Elements held about one lab axis or two: the motion of a bearing, whose couple acts about held axes alone.
#include "mechanics/figures.hpp"
#include "rod/bearing.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace skein {
namespace {

/// A bent and twisted rod whose element 2 is held about lab axes.
SceneSpec held_rod(const std::string& axes, Integrator integrator = Integrator::verlet, Law law = Law::incompressible) {
    SceneSpec scene;
    RodSpec rod = test::simple_rod(5);
    rod.material.law = law;
    rod.section = {.kind = SectionKind::elliptic, .radius = 0.05, .radius_2 = 0.03};
    rod.shape.start_curvature = Vec3d{1.5, 0.5, 1.0};
    rod.shape.velocity = {0.1, 0.3, -0.2};
    rod.shape.element_spin = {2.0, -1.0, 4.0};
    rod.hold = {.elements = {2}, .axes = axes};
    scene.rods = {rod};
    scene.time = {.duration = 1, .integrator = integrator};
    return scene;
}

/// State after a time in so many steps.
std::vector<Slot<1>> after(SceneSpec scene, double time, std::int64_t steps, int lanes = 8) {
    scene.time.dt = time / static_cast<double>(steps);
    test::Stage stage(std::move(scene), lanes);
    stage.advance(steps);
    return stage.state(0);
}

/// Largest distance of places and frames.
double apart(const std::vector<Slot<1>>& a, const std::vector<Slot<1>>& b) {
    double most = test::distance(a, b);
    for (std::size_t k = 0; k + 1 < a.size(); ++k) {
        const Mat3d one = frame(a[k]), other = frame(b[k]);
        most = std::max({most, norm(one.d1 - other.d1), norm(one.d2 - other.d2), norm(one.d3 - other.d3)});
    }
    return most;
}

/// A rod of one element with the linear law, by Runge-Kutta steps of fourth order with multipliers of the constraints:
///   J w' = c + J w x w + sum n lambda,  n = Q e,  n.w = 0
class OneElement {
public:
    OneElement(const RodGroup& group, const std::vector<Slot<1>>& state, const std::string& axes)
        : c_(group.element[0]), mass_(group.node_mass[0]) {
        for (const char axis : axes) held_.push_back(test_axis(axis));
        for (const int i : {0, 1}) {
            y_.x[i] = lane(state[to_index(i)].position, 0);
            y_.v[i] = lane(state[to_index(i)].velocity, 0);
        }
        y_.q = matrix(lane(state[0].director, 0));
        y_.w = lane(state[0].spin, 0);
    }
    static Vec3d test_axis(char axis) { return {axis == 'x' ? 1.0 : 0, axis == 'y' ? 1.0 : 0, axis == 'z' ? 1.0 : 0}; }

    void step(double h) {
        const State a = rate(y_), b = rate(along(y_, a, h / 2)), c = rate(along(y_, b, h / 2)),
                    d = rate(along(y_, c, h));
        y_ = along(along(along(along(y_, a, h / 6), b, h / 3), c, h / 3), d, h / 6);
    }
    /// Distance of places and frame.
    double from(const std::vector<Slot<1>>& state) const {
        const Mat3d q = frame(state[0]);
        return std::max({norm(lane(state[0].position, 0) - y_.x[0]), norm(lane(state[1].position, 0) - y_.x[1]),
                         norm(q.d1 - y_.q.d1), norm(q.d2 - y_.q.d2), norm(q.d3 - y_.q.d3)});
    }

private:
    struct State {
        Vec3d x[2], v[2];
        Mat3d q;
        Vec3d w;
    };
    static State along(const State& y, const State& by, double h) {
        State to = y;
        for (const int i : {0, 1}) {
            to.x[i] += h * by.x[i];
            to.v[i] += h * by.v[i];
        }
        to.q.d1 += h * by.q.d1;
        to.q.d2 += h * by.q.d2;
        to.q.d3 += h * by.q.d3;
        to.w += h * by.w;
        return to;
    }
    State rate(const State& y) const {
        const Vec3d nu = c_.inv_rest_length * (y.q * (y.x[1] - y.x[0])), n = scale(c_.stiffness, nu - Vec3d{0, 0, 1}),
                    force = transpose_times(y.q, n),
                    couple = c_.rest_length * cross(nu, n) + cross(scale(c_.inertia, y.w), y.w);
        State by{{y.v[0], y.v[1]}, {(1 / mass_) * force, (-1 / mass_) * force}, {}, scale(c_.inv_inertia, couple)};
        const Vec3d lab = transpose_times(y.q, y.w); // d' = w x d in the lab
        by.q = {cross(lab, y.q.d1), cross(lab, y.q.d2), cross(lab, y.q.d3)};
        // (n.w)' = n.w' + (n x w).w, of which the last is 0. Rows of n.J^-1 n are solved by elimination.
        std::vector<Vec3d> apart; // orthogonal to each other by J^-1
        for (const Vec3d& e : held_) {
            Vec3d one = y.q * e;
            for (const Vec3d& other : apart)
                one += (-dot(one, scale(c_.inv_inertia, other)) / dot(other, scale(c_.inv_inertia, other))) * other;
            apart.push_back(one);
            by.w += (-dot(one, by.w) / dot(one, scale(c_.inv_inertia, one))) * scale(c_.inv_inertia, one);
        }
        return by;
    }

    const ElementConstants& c_;
    double mass_;
    std::vector<Vec3d> held_;
    State y_;
};

SceneSpec one_element(const std::string& axes, Integrator integrator) {
    SceneSpec scene = held_rod(axes, integrator, Law::linear);
    RodSpec& rod = scene.rods[0];
    rod.shape = {.length = 0.2, .elements = 1, .velocity = {0.1, 0.3, -0.2}, .element_spin = {2.0, 1.0, 4.0}};
    rod.placement.tangent = {1, 2, 2};
    rod.section = {.kind = SectionKind::elliptic, .radius = 0.05, .radius_2 = 0.03};
    rod.material.youngs_modulus = 3e3;
    rod.hold.elements = {0};
    return scene;
}

/// Largest distance from the reference at the end.
double error_of_one_element(const std::string& axes, Integrator integrator, std::int64_t steps) {
    constexpr double time = 0.4;
    SceneSpec scene = one_element(axes, integrator);
    scene.time.dt = time / static_cast<double>(steps);
    test::Stage stage(std::move(scene));
    OneElement reference(stage.groups[0], stage.state(0), axes);
    for (int i = 0; i < 20000; ++i) reference.step(time / 20000);
    stage.advance(steps);
    return reference.from(stage.state(0));
}

const std::string axes_of_bearings[] = {"z", "x", "xy", "xz"};

TEST(Bearing, FollowsTheMotionWithMultipliers) {
    for (const std::string& axes : axes_of_bearings) {
        const double verlet = error_of_one_element(axes, Integrator::verlet, 800),
                     pefrl = error_of_one_element(axes, Integrator::pefrl, 100);
        EXPECT_NEAR(verlet / error_of_one_element(axes, Integrator::verlet, 1600), 4, 0.2) << axes;
        EXPECT_NEAR(pefrl / error_of_one_element(axes, Integrator::pefrl, 200), 16, 1.5) << axes;
        EXPECT_LT(verlet, 5e-5) << axes;
        EXPECT_LT(pefrl, 1e-6) << axes;
    }
}

TEST(Bearing, FollowsTheMotionWithMultipliersInImplicitSteps) {
    for (const Integrator integrator : {Integrator::implicit, Integrator::implicit_damped})
        for (const std::string& axes : axes_of_bearings) {
            const double error = error_of_one_element(axes, integrator, 400);
            EXPECT_NEAR(error / error_of_one_element(axes, integrator, 800), 4, 0.3) << axes;
            EXPECT_LT(error, 2e-4) << axes;
        }
}

/// No couple acts about free axes from outside.
TEST(Bearing, KeepsTheAngularMomentumAboutFreeAxes) {
    for (const Integrator integrator : {Integrator::verlet, Integrator::pefrl, Integrator::implicit})
        for (const Law law : test::energy_laws())
            for (const std::string& axes : axes_of_bearings) {
                SceneSpec scene = held_rod(axes, integrator, law);
                if (is_implicit(integrator)) scene.time.dt = 1e-3;
                test::Stage stage(scene);
                const Vec3d before = test::momenta(stage.groups[0], stage.state(0)).angular;
                stage.advance(is_implicit(integrator) ? 300 : 3000);
                const double rounding = is_implicit(integrator) ? 1e-9 : 1e-11; // of corrections that have ended
                const Vec3d change = test::momenta(stage.groups[0], stage.state(0)).angular - before;
                for (const char axis : {'x', 'y', 'z'}) {
                    const double about = std::abs(dot(change, OneElement::test_axis(axis)));
                    if (axes.find(axis) == std::string::npos) {
                        EXPECT_LT(about, rounding * norm(before)) << axes << " " << axis;
                    } else {
                        EXPECT_GT(about, 1e-4 * norm(before)) << axes << " " << axis;
                    }
                }
            }
}

TEST(Bearing, StaysHeldOverManySteps) {
    for (const std::string& axes : axes_of_bearings) {
        test::Stage stage(held_rod(axes));
        const Bearing bearing = bearings_of(stage.groups[0]).front();
        std::vector<Slot<1>> state(6);
        const auto axis_in_body = [&] {
            stage.rods->export_rod(0, state);
            return lane(state[2].director, 0) * bearing.axis;
        };
        const Vec3d before = axis_in_body();
        double most = 0, fastest = 0, turned = 0;
        for (std::int64_t step = 1000; step <= 100000; step += 1000) {
            stage.advance(step);
            const Vec3d axis = axis_in_body(), rate = lane(state[2].spin, 0);
            fastest = std::max(fastest, norm(rate));
            turned = std::max(turned, norm(axis - before));
            most = std::max(most, bearing.turns_about ? norm(cross(axis, rate)) : std::abs(dot(axis, rate)));
        }
        EXPECT_LT(most, 1e-15 * fastest) << axes;
        if (bearing.turns_about) EXPECT_LT(turned, 1e-13) << axes;
        else EXPECT_GT(turned, 0.1) << axes;
    }
}

/// Total energy of a state.
double energy(const test::Stage& stage) {
    const RodFigures f = figures_of(stage.groups[0], stage.state(0), 0);
    double sum = 0;
    for (int i = RodFigures::translation; i <= RodFigures::twist; ++i) sum += f.sum[i];
    return sum;
}

/// Its error swings with the square of the step, and does not grow.
TEST(Bearing, KeepsTheEnergy) {
    struct Error {
        double early = 0, late = 0;
    };
    const auto error = [](const std::string& axes, std::int64_t parts) {
        SceneSpec scene = held_rod(axes);
        scene.time.dt = test::Stage(scene).plan.dt / static_cast<double>(parts);
        test::Stage stage(scene);
        const double start = energy(stage);
        Error most;
        for (std::int64_t i = 1; i <= 2000; ++i) {
            stage.advance(10 * parts * i);
            double& half = i <= 1000 ? most.early : most.late;
            half = std::max(half, std::abs(energy(stage) / start - 1));
        }
        return most;
    };
    for (const std::string& axes : axes_of_bearings) {
        const Error coarse = error(axes, 2), fine = error(axes, 4);
        EXPECT_NEAR(coarse.early / fine.early, 4, 1) << axes;
        EXPECT_LT(fine.late, 1.2 * fine.early) << axes;
        EXPECT_LT(fine.early, 2e-4) << axes;
    }
}

/// Rates that differ about d1 and d3.
TEST(Bearing, KeepsItsOrderUnderDamping) {
    for (const DampingScheme scheme : {DampingScheme::midpoint, DampingScheme::exponential})
        for (const std::string& axes : axes_of_bearings) {
            SceneSpec scene = held_rod(axes);
            scene.time.damping = scheme;
            scene.damping.push_back({.damping = {.kind = DampingKind::legacy, .rate = 0.05}});
            const auto exact = after(scene, 0.1, 64000);
            const double coarse = apart(after(scene, 0.1, 1000), exact), fine = apart(after(scene, 0.1, 2000), exact);
            EXPECT_NEAR(coarse / fine, 4, 0.2) << axes;
        }
}

TEST(Bearing, HasTheSameBitsAtAnyWidth) {
    if (const std::string reason = test::one_width(); !reason.empty()) GTEST_SKIP() << reason;
    for (const std::string& axes : axes_of_bearings) {
        const auto one = after(held_rod(axes), 0.02, 400, 1), eight = after(held_rod(axes), 0.02, 400, 8);
        for (std::size_t k = 0; k < one.size(); ++k)
            EXPECT_EQ(std::memcmp(&one[k], &eight[k], sizeof one[k]), 0) << axes << " " << k;
    }
}

} // namespace
} // namespace skein
