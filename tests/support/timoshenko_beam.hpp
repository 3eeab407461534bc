// A clamped circular rod of small deflection w and turn theta, with shear and rotary inertia: statics and frequencies.
//   w' = theta + V/s,  theta' = M/(EI),  M' = -V - rho I W^2 theta,  V' = -rho A W^2 w,     s = alpha_c G A
//   w = theta = 0 at the clamp, M = V = 0 at the free end: the block of exp(A L) from (M, V) to (M, V) is singular.
//   under a tip force F:  w(s) = F s/(alpha_c G A) + F (L s^2/2 - s^3/6)/(E I)
#pragma once

#include "skein/core/index.hpp"
#include "skein/rod/rod_spec.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace skein::test {

struct TimoshenkoBeam {
    using Mat4 = std::array<std::array<double, 4>, 4>; ///< of (w, theta, M, V)

    double length, radius, density, youngs, shear;
    double area = std::numbers::pi * radius * radius, second_moment = 0.25 * area * radius * radius;
    double shearing = 27.0 / 28 * shear * area; ///< alpha_c G A, N

    /// Deflection at s under a transverse force at the tip.
    double deflection(double force, double s) const {
        return force * s / shearing + force * (0.5 * length * s * s - s * s * s / 6) / (youngs * second_moment);
    }

    /// exp(A s) by its series, squared four times.
    Mat4 transfer(double frequency, double s) const {
        const double w2 = frequency * frequency;
        const Mat4 rate{{{0, 1, 0, 1 / shearing},
                         {0, 0, 1 / (youngs * second_moment), 0},
                         {0, -density * second_moment * w2, 0, -1},
                         {-density * area * w2, 0, 0, 0}}};
        const auto times = [](const Mat4& a, const Mat4& b) {
            Mat4 c{};
            for (int i = 0; i < 4; ++i)
                for (int j = 0; j < 4; ++j)
                    for (int k = 0; k < 4; ++k) c[i][j] += a[i][k] * b[k][j];
            return c;
        };
        Mat4 sum{}, term{};
        for (int i = 0; i < 4; ++i) sum[i][i] = term[i][i] = 1;
        for (int order = 1; order < 40; ++order) {
            term = times(term, rate);
            for (int i = 0; i < 4; ++i)
                for (int j = 0; j < 4; ++j) sum[i][j] += term[i][j] *= s / 16 / order;
        }
        for (int i = 0; i < 4; ++i) sum = times(sum, sum);
        return sum;
    }
    /// Of what two of (w, theta, M, V) at s = 0 make of two at the end: 0 at the frequencies of a beam that holds the
    /// others at 0.
    struct Ends {
        int start[2] = {2, 3}, end[2] = {2, 3}; ///< clamped, free
    };
    double determinant(double frequency, const Ends& ends) const {
        const Mat4 t = transfer(frequency, length);
        const auto& [a, b] = ends.start;
        const auto& [c, d] = ends.end;
        return t[c][a] * t[d][b] - t[c][b] * t[d][a];
    }
    /// Lowest roots, rad/s: a scan in steps of a tenth of the first slender-rod frequency, then bisection.
    template <int modes> std::array<double, modes> frequencies(const Ends& ends = {}) const {
        std::array<double, modes> root{};
        const double step = 0.35 * std::sqrt(youngs * second_moment / (density * area)) / (length * length);
        double low = 0.01 * step;
        for (int found = 0; found < modes; low += step) {
            if (determinant(low, ends) * determinant(low + step, ends) > 0) continue;
            double a = low, b = low + step;
            for (int i = 0; i < 100; ++i) {
                const double middle = 0.5 * (a + b);
                (determinant(a, ends) * determinant(middle, ends) <= 0 ? b : a) = middle;
            }
            nth(root, found++) = 0.5 * (a + b);
        }
        return root;
    }
    /// w and theta at s of the mode at a root; w(L) = 1.
    std::array<double, 2> shape(double frequency, double s) const {
        const auto at = [&](const Mat4& t, const Mat4& end, int row) {
            return t[row][2] * end[2][3] - t[row][3] * end[2][2];
        };
        const Mat4 end = transfer(frequency, length), t = transfer(frequency, s);
        return {at(t, end, 0) / at(end, end, 0), at(t, end, 1) / at(end, end, 0)};
    }
};

/// The beam as a rod of n elements, clamped at the start.
inline RodSpec clamped_rod(const TimoshenkoBeam& beam, long n) {
    RodSpec rod;
    rod.name = "rod";
    rod.material = {.density = beam.density, .youngs_modulus = beam.youngs, .shear_modulus = beam.shear};
    rod.section = {.radius = beam.radius};
    rod.shape = {.length = beam.length, .elements = n};
    rod.start = EndKind::clamped;
    return rod;
}

} // namespace skein::test
