// The published travelling wave of muscle couple, which runs from the rod's end to its start.   theory.md (39)-(40)
//   a_i(t) = r(t) A_i sin(2 pi t/T - k s_i + phi)                    [N m], s_i = (l_0 + .. + l_i)/L, i = 0 .. n - 1
//   c_j += Q_j a_{n-1-j} d,   c_{j-1} -= Q_{j-1} a_{n-1-j} d         [N m] body, at vertices j = 1 .. n - 1; d a lab direction
// A_i is a table or a cubic B-spline at s_i. The wave of loads/muscle_wave.hpp counts arc length from the start, in metres.
// Source: Gazzola et al. 2018, as PyElastica's MuscleTorques computes it. Cost: 30 flop per element.
#pragma once

#include "core/fields.hpp"
#include "loads/bspline.hpp"
#include "loads/ramp.hpp"
#include "rod/tile.hpp"

#include <cmath>
#include <numbers>
#include <span>
#include <vector>

namespace skein {

struct MuscleTorques {
    static constexpr std::string_view kind = "muscle_torques";
    std::vector<double> coefficients; ///< of the B-spline, N m, at least 4
    std::vector<double> table;        ///< A_i, N m, [n]; instead of the spline
    double period = 0;                ///< T, s
    double wave_number = 0;           ///< k, rad per rod length
    double phase = 0;                 ///< phi, rad
    Vec3d direction{0, 0, 1};         ///< d, lab
    double ramp = 0;                  ///< s

    void fields(FieldVisitor& f) {
        f.visit({.name = "coefficients", .unit = "N m", .text = "cubic B-spline from the rod's end to its start, at least 4; end values are met"}, coefficients);
        f.visit({.name = "table", .unit = "N m", .text = "instead of a spline: amplitudes at s_i, one per element, from the rod's end to its start"}, table);
        f.visit({.name = "period", .unit = "s", .text = "T", .required = true, .above = 0}, period);
        f.visit({.name = "wave_number", .unit = "rad", .text = "k, over the whole rod: 2 pi times the number of waves", .required = true}, wave_number);
        f.visit({.name = "phase", .unit = "rad", .text = "phi"}, phase);
        f.visit({.name = "direction", .unit = "-", .text = "axis of the couple, lab frame"}, direction);
        f.visit({.name = "ramp", .unit = "s", .text = "linear rise from 0", .at_least = 0}, ramp);
    }

    /// A cos(k s - phi) and A sin(k s - phi) at vertex j, so that a step costs one sine and cosine in all.
    void bind_group(const RodGroup& group) {
        const auto n = static_cast<std::size_t>(group.elements());
        in_phase.assign(n, 0);
        quadrature.assign(n, 0);
        double length = 0, sum = 0;
        for (const ElementConstants& e : group.element) length += e.rest_length;
        for (std::size_t i = 0; i + 1 < n; ++i) {
            sum += group.element[i].rest_length;
            const double s = sum / length, angle = wave_number * s - phase;
            const double local = table.empty() ? cubic_bspline(coefficients, s) : table[i];
            in_phase[n - 1 - i] = local * std::cos(angle);
            quadrature[n - 1 - i] = local * std::sin(angle);
        }
    }
    void prepare(std::span<const Step> steps) {
        for (const Step& step : steps) {
            const double angle = 2 * std::numbers::pi / period * step.time, r = ramp_at(step.time, ramp);
            sine[step.slot] = r * std::sin(angle);
            cosine[step.slot] = r * std::cos(angle);
        }
    }
    std::vector<double> in_phase, quadrature; ///< [n], by vertex; entry 0 unused
    double sine[Clock::largest_batch], cosine[Clock::largest_batch];

    template <int W> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const {
        for (int j = 1; j < rod.n; ++j) {
            const double m = in_phase[static_cast<std::size_t>(j)] * sine[step.slot] - quadrature[static_cast<std::size_t>(j)] * cosine[step.slot];
            const auto couple = broadcast<W>(m * direction);
            load[j].couple += rod.slot[j].director * couple;
            load[j - 1].couple -= rod.slot[j - 1].director * couple;
        }
    }
};

} // namespace skein
