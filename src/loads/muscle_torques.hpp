// Published travelling wave of muscle couple, which runs from the rod's end to its start. theory.md (39)-(40)
//   a_i(t) = r(t) A_i sin(2 pi t/T - k s_i + phi)                    [N m], s_i = (l_0 + .. + l_i)/L, i = 0 .. n - 1
//   c_j += Q_j a_{n-1-j} d,   c_{j-1} -= Q_{j-1} a_{n-1-j} d         [N m] body, at vertices j = 1 .. n - 1; d a lab
//                                                                    direction, or with `frame` = "body" a material
//                                                                    one, theory.md (36a)
// A ring has a vertex j = 0 too, where it closes; published codes leave it out. Ends clamped by half cells, which those
// do not have, are vertices: j = 0 with a_{n-1}, and j = n with the a of s = 0. A_i is a table or a cubic B-spline at
// s_i. The wave of loads/muscle_wave.hpp counts arc length from the start, in metres. Source: Gazzola et al. 2018, as
// PyElastica's MuscleTorques computes it.
#pragma once

#include "loads/bspline.hpp"
#include "loads/vertex_wave.hpp"
#include "rod/shape_places.hpp"
#include "skein/core/fields.hpp"
#include "skein/core/index.hpp"
#include "skein/loads/load.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace skein {

struct MuscleTorques : WaveLoad<MuscleTorques> {
    static constexpr std::string_view kind = "muscle_torques";
    static constexpr bool for_rigid_bodies = false;
    std::vector<double> coefficients; ///< coefficients of the B-spline, N m, at least 4
    std::vector<double> table;        ///< A_i, N m, [n]; instead of the spline
    double period = 0;                ///< T, s
    double wave_number = 0;           ///< k, rad per rod length
    double phase = 0;                 ///< phi, rad
    Vec3d direction{0, 0, 1};         ///< d
    LoadFrame frame = LoadFrame::lab; ///< axes of d
    Ramp ramp;

    void fields(FieldVisitor& f) {
        f.visit({.name = "coefficients",
                 .unit = "N m",
                 .text = "coefficients of a cubic B-spline from the rod's end to its start, at least 4; it passes "
                         "through the first and last"},
                coefficients);
        f.visit({.name = "table",
                 .unit = "N m",
                 .text = "amplitudes at s_i instead of a spline, one per element, from the rod's end to its start"},
                table);
        f.visit({.name = "period", .unit = "s", .text = "T", .required = true, .above = 0}, period);
        f.visit({.name = "wave_number",
                 .unit = "rad",
                 .text = "k, over the whole rod: 2 pi times the number of waves",
                 .required = true},
                wave_number);
        common_fields(f, *this);
    }
    void check(RodSpecs groups, Objections& objections) const {
        check_direction(objections);
        if (table.empty()) {
            if (coefficients.size() < 4)
                objections.add(
                    "", "muscle_torques need 'coefficients' [N m], at least 4 of them, or a 'table'; there are " +
                            std::to_string(coefficients.size()));
            return;
        }
        objections.unused({"coefficients"}, "beside 'table', which gives the amplitude of every element");
        for (const RodSpec* rods : groups)
            objections.length("table", table.size(), rods->shape.elements,
                              "one for each element of group '" + rods->name + "'");
    }
    std::string refine(const Shape& was, const Shape& now) {
        if (table.empty()) return {};
        const auto ends = [](const Shape& shape) { // s_i of elements
            const auto nodes = nodes_of(shape);
            return std::vector<double>(nodes.begin() + 1, nodes.end());
        };
        table = between(ends(was), table, ends(now), was.closed);
        return "'table' is taken as linear between its places";
    }

    /// Amplitude at s on the way from the end to the start, N m; `i`: entry of the table.
    double amplitude_at(double s, int i) const {
        return table.empty() ? cubic_bspline(coefficients, s) : nth(table, i);
    }
    double phase_at(double s) const { return wave_number * s - phase; }
    void bind_group(const RodGroup& group) {
        const int n = group.elements();
        wave.resize(n, frame);
        double length = 0, sum = 0;
        for (const ElementConstants& e : group.element) length += e.rest_length;
        for (int i = 0; i < group.cells(); ++i) { // the last is where a ring closes
            sum += nth(group.element, i).rest_length;
            const double s = std::min(1.0, sum / length);
            wave.set(n - 1 - i, amplitude_at(s, i), phase_at(s));
        }
        wave.set_ends(group, amplitude_at(1, n - 1), phase_at(1), amplitude_at(0, 0), phase_at(0));
    }
};

} // namespace skein
