// Large rotations in three dimensions, at rest: a dead force F on the end of a clamped rod, E I/L^2 (4, 1.2, 0) on a straight one
// and E I/L^2 (6, 1.8, 0) on an arc of 45 degrees in the y-z plane (r = 0.03 L, G = E/3). The continuum of the incompressible law:
//   n = Q F,  m = Q [(x(L) - x) x F]                                                       balance, body axes
//   nu_1,2 = n_1,2/(alpha_c G A),  kappa - kappa0 = e^3 B^-1 m,  E A (1 - 1/e) = n_3 + (3/2) e^2 m.B^-1 m
//   x' = Q^T nu,  Q' = -[kappa] Q
// and of the linear law, with kappa - kappa0 = B^-1 m and E A (e - 1) = n_3,
// solved by shooting for x(L). Two resolutions make a Richardson value (4 u_2n - u_n)/3, of fourth order in the plane. The bend
// also twists, and keeps a small term of third order: the wall's moment is resolved in the frame of the half cell's middle.
//
// The published tips have six digits. Those of the linear law are met; those of the incompressible law are 3e-6 and 5e-6 away
// from this continuum, to which Richardson values converge.
#include "validation/study.hpp"

#include <array>
#include <numbers>

namespace skein {
namespace {

constexpr double radius = 0.03, area = std::numbers::pi * radius * radius; // L = rho = E = 1
constexpr double bending = 0.25 * area * radius * radius, twisting = 2 * bending / 3, shearing = 27.0 / 28 / 3 * area;

struct Case {
    const char* name;
    Law law;
    Vec3d rest_curvature, force; ///< 1/L; EI/L^2
    Vec3d published;             ///< tip
    double published_error;
};
constexpr Vec3d arc{-0.25 * std::numbers::pi, 0, 0};
constexpr Case cases[] = {
    {"straight", Law::incompressible, {0, 0, 0}, {4, 1.2, 0}, {0.653364, 0.196009, 0.658350}, 6e-6},
    {"straight, linear", Law::linear, {0, 0, 0}, {4, 1.2, 0}, {0.651861, 0.195558, 0.659299}, 1e-6},
    {"bend", Law::incompressible, arc, {6, 1.8, 0}, {0.688783, 0.348759, 0.492498}, 6e-6},
    {"bend, linear", Law::linear, arc, {6, 1.8, 0}, {0.687119, 0.348947, 0.493535}, 1e-6},
};

/// Tip of the rod that bends under `force` with the lever arms of a tip at `end`; fourth-order Runge-Kutta.
Vec3d shoot(const Case& c, const Vec3d& force, const Vec3d& end) {
    struct State {
        Vec3d x;
        Mat3d q;
    };
    const auto rate = [&](const State& s) {
        const Vec3d n = s.q * force, m = s.q * cross(end - s.x, force);
        const Vec3d bent{m.x / bending, m.y / bending, m.z / twisting};
        double e = 1;
        if (c.law == Law::linear) e = 1 + n.z / area;
        else for (int i = 0; i < 40; ++i) e = 1 / (1 - (n.z + 1.5 * e * e * dot(m, bent)) / area);
        const Vec3d kappa = c.rest_curvature + (c.law == Law::linear ? 1 : e * e * e) * bent;
        const auto turned = [&](const Vec3d& column) { return -cross(kappa, column); };
        const Vec3d c1 = turned({s.q.d1.x, s.q.d2.x, s.q.d3.x}), c2 = turned({s.q.d1.y, s.q.d2.y, s.q.d3.y}),
                    c3 = turned({s.q.d1.z, s.q.d2.z, s.q.d3.z});
        return State{transpose_times(s.q, Vec3d{n.x / shearing, n.y / shearing, e}),
                     {{c1.x, c2.x, c3.x}, {c1.y, c2.y, c3.y}, {c1.z, c2.z, c3.z}}};
    };
    const auto ahead = [](const State& a, double h, const State& r) {
        return State{fma(h, r.x, a.x), {fma(h, r.q.d1, a.q.d1), fma(h, r.q.d2, a.q.d2), fma(h, r.q.d3, a.q.d3)}};
    };
    constexpr int steps = 1000;
    constexpr double h = 1.0 / steps;
    State s{{0, 0, 0}, identity};
    for (int i = 0; i < steps; ++i) {
        const State k1 = rate(s), k2 = rate(ahead(s, h / 2, k1)), k3 = rate(ahead(s, h / 2, k2)), k4 = rate(ahead(s, h, k3));
        s = ahead(ahead(ahead(ahead(s, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
    }
    return s.x;
}

/// Newton's method for x(L) = shoot(x(L)), the load in twenty parts.
Vec3d boundary_value_problem(const Case& c) {
    Vec3d end = shoot(c, {0, 0, 0}, {0, 0, 0});
    for (int part = 1; part <= 20; ++part) {
        const Vec3d force = (bending * part / 20) * c.force;
        const auto miss = [&](const Vec3d& x) { return shoot(c, force, x) - x; };
        for (int iteration = 0; iteration < (part < 20 ? 2 : 6); ++iteration) {
            constexpr double d = 1e-5;
            const Vec3d r = miss(end);
            const auto column = [&](const Vec3d& direction) {
                return (0.5 / d) * (miss(end + d * direction) - miss(end - d * direction));
            };
            const Vec3d a = column({1, 0, 0}), b = column({0, 1, 0}), g = column({0, 0, 1});
            const double determinant = dot(a, cross(b, g));
            end -= (1 / determinant) * Vec3d{dot(r, cross(b, g)), dot(a, cross(r, g)), dot(a, cross(b, r))};
        }
    }
    EXPECT_LT(norm(shoot(c, bending * c.force, end) - end), 1e-11) << c.name;
    return end;
}

Vec3d tip(const Case& c, long n, double& dt, test::Cost& cost) {
    RodSpec rod;
    rod.name = "rod";
    rod.material = {.density = 1, .youngs_modulus = 1, .law = c.law};
    rod.section = {.radius = radius};
    rod.shape = {.length = 1, .elements = n, .rest_curvature = c.rest_curvature};
    rod.start = EndKind::clamped;
    const double omega = test::cantilever_frequency(rod);
    test::Stage stage(test::coming_to_rest(rod, omega, {{.load = EndForce{.end = bending * c.force}}}), 1);
    dt = stage.plan.dt;
    test::come_to_rest(stage, omega, cost);
    return lane(stage.state(0).back().position, 0);
}

TEST(LargeRotation, TipsMeetBoundaryValueProblemAndRichardsonIsFourthOrder) {
    test::ErrorTable table("large_rotation");
    for (const Case& c : cases) {
        const std::string name = c.name;
        const Vec3d exact = boundary_value_problem(c);
        std::printf("%s: exact tip (%.8f, %.8f, %.8f)\n", c.name, exact.x, exact.y, exact.z);
        for (const double off : {exact.x - c.published.x, exact.y - c.published.y, exact.z - c.published.z})
            EXPECT_LE(std::abs(off), c.published_error) << name;

        Vec3d coarse{}, extrapolated{};
        test::Cost coarse_cost;
        for (const long n : {5, 10, 20, 40, 80}) {
            double dt = 0;
            test::Cost cost;
            const Vec3d fine = tip(c, n, dt, cost);
            const double order = table.add(name, n, dt, norm(fine - exact), cost);
            if (n >= 20) {
                EXPECT_NEAR(order, 2.0, 0.1) << name << ", n = " << n;
            }
            if (n > 5) {
                extrapolated = (4.0 / 3) * fine - (1.0 / 3) * coarse;
                const test::Cost both{cost.element_steps + coarse_cost.element_steps, cost.seconds + coarse_cost.seconds};
                const double order_4 = table.add(name + " Richardson", n, dt, norm(extrapolated - exact), both);
                if (n == 80) {
                    EXPECT_NEAR(order_4, norm(c.rest_curvature) > 0 ? 3.0 : 4.0, 0.2) << name;
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
