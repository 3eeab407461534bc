// A clamped rod magnetised along its axis in a transverse field, relaxed to rest, against its boundary-value problem.
//   inextensible elastica   EI theta'' + M A B sin(pi/2 - theta) = 0,  theta(0) = 0, theta'(L) = 0       (Wang et al. 2020)
//   incompressible law      m' = -M A B cos(theta),  theta' = kappa = m e^3/EI,  EA (1 - 1/e) = (3/2) EI kappa^2/e^4,  x' = e sin(theta)
// The second is the continuum of the discrete rod, so the error against it falls with dl^2; the first is the published yardstick.
#include "validation/study.hpp"

#include <numbers>

namespace skein {
namespace {

constexpr double length = 1, radius = 0.01, youngs = 1e6, density = 1e3, field = 0.08;
constexpr double bonds[] = {0.1, 1, 3, 10};
constexpr long resolutions[] = {10, 20, 40, 50};

struct Tip {
    double x, z;
};

/// Shooting for the base moment, m(L) = 0, with fourth-order Runge-Kutta. Lengths in L, moments in EI/L.
Tip boundary_value_problem(double bond, bool extensible) {
    constexpr int steps = 4000;
    const double compliance = extensible ? 1.5 * 0.25 * radius * radius / (length * length) : 0; // (3/2) EI/(EA L^2)
    struct State {
        double theta, m, x, z;
    };
    const auto rate = [&](const State& s) {
        double e = 1;
        for (int i = 0; i < 30 && extensible; ++i) e = 1 / (1 - compliance * s.m * s.m * e * e);
        return State{s.m * e * e * e, -bond * std::cos(s.theta), e * std::sin(s.theta), e * std::cos(s.theta)};
    };
    const auto end = [&](double base_moment) {
        State s{0, base_moment, 0, 0};
        const double h = 1.0 / steps;
        const auto ahead = [](const State& a, double d, const State& r) { return State{a.theta + d * r.theta, a.m + d * r.m, a.x + d * r.x, a.z + d * r.z}; };
        for (int i = 0; i < steps; ++i) {
            const State k1 = rate(s), k2 = rate(ahead(s, h / 2, k1)), k3 = rate(ahead(s, h / 2, k2)), k4 = rate(ahead(s, h, k3));
            s = ahead(ahead(ahead(ahead(s, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
        }
        return s;
    };
    double low = 0, high = bond + 1; // m(0) <= bond, since cos <= 1
    for (int i = 0; i < 100; ++i) {
        const double middle = 0.5 * (low + high);
        (end(middle).m > 0 ? high : low) = middle;
    }
    const State s = end(0.5 * (low + high));
    return {s.x, s.z};
}

/// One group per bond and resolution, damped until it rests.
SceneSpec scene() {
    SceneSpec scene;
    const double first_frequency = 3.516 * 0.5 * radius * std::sqrt(youngs / density) / (length * length);
    scene.time = {.duration = 20 / first_frequency};
    for (const double bond : bonds)
        for (const long n : resolutions) {
            RodSpec rod;
            rod.name = "rod" + std::to_string(scene.rods.size());
            rod.material = {.density = density, .youngs_modulus = youngs};
            rod.section = {.radius = radius};
            rod.shape = {.length = length, .elements = n};
            rod.start = EndKind::clamped;
            rod.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = bond * youngs * radius * radius / (4 * field * length * length)};
            scene.rods.push_back(rod);
        }
    scene.loads.push_back({.load = MagneticField{.constant = {field, 0, 0}, .ramp = 1 / first_frequency}});
    scene.damping.push_back({.damping = {.kind = DampingKind::uniform, .rate = 2 * first_frequency}});
    return scene;
}

TEST(MagnetisedCantilever, MeetsItsBoundaryValueProblemAtSecondOrder) {
    test::Stage stage(scene(), 1, 2);
    stage.advance(stage.plan.steps);
    test::ErrorTable table("magnetised_cantilever");
    std::size_t i = 0;
    for (const double bond : bonds) {
        const Tip own = boundary_value_problem(bond, true), published = boundary_value_problem(bond, false);
        const double deflection = std::hypot(published.x, 1 - published.z);
        double error[std::size(resolutions)], published_error = 0;
        for (std::size_t r = 0; r < std::size(resolutions); ++r, ++i) {
            const Vec3d tip = lane(stage.state(i).back().position, 0);
            error[r] = std::hypot(tip.x - own.x, tip.z - own.z) / deflection;
            published_error = std::hypot(tip.x - published.x, tip.z - published.z) / deflection;
            EXPECT_LT(std::abs(tip.y), 1e-12);
            table.add("bond " + std::to_string(bond).substr(0, 4), resolutions[r], stage.plan.dt, error[r]);
        }
        const double order = std::log2(error[1] / error[2]);
        std::printf("bond %4.1f: tip (%.6f, %.6f), error at n = 10, 20, 40, 50: %.2e %.2e %.2e %.2e, order %.3f; n = 50 against the inextensible elastica %.2e\n",
                    bond, own.x, own.z, error[0], error[1], error[2], error[3], order, published_error);
        EXPECT_GE(order, 1.9) << "bond " << bond;
        EXPECT_LE(error[3], 1e-3) << "bond " << bond;
        EXPECT_LE(published_error, 1e-3) << "bond " << bond;
    }
}

TEST(MagnetisedCantilever, FrozenClampIsFirstOrder) {
    SceneSpec frozen = scene();
    const auto bond_1 = frozen.rods.begin() + std::size(resolutions);
    frozen.rods = std::vector<RodSpec>(bond_1, bond_1 + std::size(resolutions));
    for (RodSpec& rod : frozen.rods) rod.start = EndKind::clamped_frozen;
    test::Stage stage(frozen, 1, 2);
    stage.advance(stage.plan.steps);
    const Tip own = boundary_value_problem(1, true);
    const auto error = [&](std::size_t r) {
        const Vec3d tip = lane(stage.state(r).back().position, 0);
        return std::hypot(tip.x - own.x, tip.z - own.z);
    };
    EXPECT_NEAR(std::log2(error(1) / error(2)), 1.0, 0.15);
    EXPECT_GT(error(3), 1e-2 * std::hypot(own.x, 1 - own.z)) << "the published clamp is coarse at n = 50";
}

} // namespace
} // namespace skein
