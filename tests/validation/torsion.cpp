// Torsion of elliptic sections: the twist under a couple against St Venant, and the load at which a strip on edge tips
// over sideways against its boundary-value problem.
//
// A clamped strip of bending stiffness B_w (weak) and B_s, torsional stiffness C, with a dead force P on its tip in the
// stiff direction. Before it buckles it is a plane elastica, B_s k' = -n_1 with n_1 = P cos(theta), n_3 = P sin(theta),
// k = theta'. A small motion out of that plane has, from the balance m' + kappa x m + e_3 x n = 0, n' + kappa x n = 0,
//   B_w kappa_1' = n_2 + (B_s - C) k kappa_3,   C kappa_3' = (B_w - B_s) k kappa_1,   n_2' = kappa_1 n_3 - kappa_3 n_1
// with kappa_1 = kappa_3 = 0 at the tip and n_2 = 0 at the clamp. Where k is small this is Prandtl's 4.0126 sqrt(B_w
// C)/L^2, over sqrt((1 - B_w/B_s)(1 - C/B_s)) to the next order (Hodges, Peters 1975).
#include "loads/end_couple.hpp"
#include "loads/end_force.hpp"
#include "support/statics.hpp"
#include "validation/study.hpp"

#include <array>
#include <numbers>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

struct Strip {
    double weak, strong, torsion; ///< N m^2
};

/// theta, k, kappa_1, kappa_3, n_2 at distance x from the tip.
using Along = std::array<double, 5>;

/// At the clamp of a strip of length 1, tip turned by `tip`.
Along at_clamp(const Strip& s, double force, double tip) {
    const auto rate = [&](const Along& y) -> Along { // by x, from the tip on: the negative of that by s
        const double n1 = force * std::cos(y[0]), n3 = force * std::sin(y[0]), k = y[1];
        return {-k, n1 / s.strong, -(y[4] + (s.strong - s.torsion) * k * y[3]) / s.weak,
                -(s.weak - s.strong) * k * y[2] / s.torsion, -(y[2] * n3 - y[3] * n1)};
    };
    constexpr int steps = 1000;
    const double h = 1.0 / steps;
    const auto moved = [](const Along& y, double by, const Along& rate_) {
        Along z;
        for (std::size_t i = 0; i < 5; ++i) z[i] = y[i] + by * rate_[i];
        return z;
    };
    Along y{tip, 0, 0, 0, 1};
    for (int i = 0; i < steps; ++i) {
        const Along a = rate(y), b = rate(moved(y, 0.5 * h, a)), c = rate(moved(y, 0.5 * h, b)),
                    d = rate(moved(y, h, c));
        for (std::size_t j = 0; j < 5; ++j) y[j] += h / 6 * (a[j] + 2 * b[j] + 2 * c[j] + d[j]);
    }
    return y;
}

template <class F> double bisect(double low, double high, F&& negative) {
    for (int i = 0; i < 50; ++i) {
        const double middle = 0.5 * (low + high);
        (negative(middle) ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

/// n_2 at the clamp.
double misfit(const Strip& s, double force) {
    const double tip = bisect(0, pi / 2, [&](double angle) { return at_clamp(s, force, angle)[0] < 0; });
    return at_clamp(s, force, tip)[4];
}

double prandtl(const Strip& s) { return 4.0126 * std::sqrt(s.weak * s.torsion); }

double critical_load(const Strip& s) {
    double force = 0.5 * prandtl(s);
    const double step = 0.02 * prandtl(s);
    while (misfit(s, force + step) > 0) force += step;
    return bisect(force, force + step, [&](double p) { return misfit(s, p) > 0; });
}

/// Along z, 1 m long, wide along x.
RodSpec strip(double ratio, long n) {
    RodSpec spec = test::simple_rod(n);
    spec.material.youngs_modulus = 1e9;
    spec.section = {.kind = SectionKind::elliptic, .radius = 0.01, .radius_2 = 0.01 / ratio};
    spec.start = EndKind::clamped;
    return spec;
}

Strip constants(double ratio) {
    const double a = 0.01, b = a / ratio, e = 1e9, g = e / 3;
    return {e * pi / 4 * a * b * b * b, e * pi / 4 * a * a * a * b, g * pi * a * a * a * b * b * b / (a * a + b * b)};
}

double measured_load(double ratio, long n) {
    const RodGroup group(strip(ratio, n), 0, 0, "");
    test::Statics rod(group);
    double force = 0;
    const double first = 0.1 * prandtl(constants(ratio));
    const auto stable_at = [&](double p) {
        rod.loads = {EndForce{.end = {p, 0, 0}}};
        rod.rest();
        return rod.stability() > 0;
    };
    while (stable_at(force + first)) {
        force += first;
        if (force > 100 * first) return HUGE_VAL;
    }
    return bisect(force, force + first, stable_at);
}

TEST(Torsion, TurnsTheEndAsStVenantSays) {
    for (const double ratio : {0.5, 1.0, 2.0, 4.0, 10.0})
        for (const Law law : {Law::incompressible, Law::linear}) {
            RodSpec spec = strip(ratio, 8);
            spec.material.law = law;
            const RodGroup group(spec, 0, 0, "");
            test::Statics rod(group);
            const double torsion = constants(ratio).torsion, turn = 0.01;
            rod.loads = {EndCouple{.end = {0, 0, turn * torsion}}};
            rod.rest();
            // The last element stands half of its length before the end.
            const Vec3d turned = relative_rotation(lane(rod.state[7].director, 0), group.frame());
            EXPECT_NEAR(turned.z, turn * (1 - 0.5 / 8), 1e-6 * turn) << ratio;
        }
}

TEST(Torsion, StripsTipOverAtTheLoadOfTheBoundaryValueProblem) {
    test::ErrorTable table("lateral_buckling");
    for (const double ratio : {2.0, 3.0, 5.0, 10.0}) {
        const Strip s = constants(ratio);
        const double exact = critical_load(s);
        if (ratio == 10) {
            EXPECT_NEAR(exact, prandtl(s) / std::sqrt((1 - s.weak / s.strong) * (1 - s.torsion / s.strong)),
                        5e-3 * exact);
        }
        const std::string name = "1:" + std::to_string(static_cast<int>(ratio));
        const double coarse = measured_load(ratio, 10), fine = measured_load(ratio, 20);
        table.add(name, 10, 0, std::abs(coarse / exact - 1));
        const double order = table.add(name, 20, 0, std::abs(fine / exact - 1));
        // A strip of 1:2 hangs down by a third of its length before it tips over, and is as much farther from its
        // limit.
        EXPECT_LT(std::abs(fine / exact - 1), ratio > 2 ? 3e-3 : 5e-3) << name;
        EXPECT_NEAR(order, 2, 0.2) << name;
        EXPECT_LT(std::abs((4 * fine - coarse) / 3 / exact - 1), 5e-4) << name;
    }
}

} // namespace
} // namespace skein
