// Travelling wave of internal couple, as muscles make it: equal and opposite on the two elements of every vertex.
// theory.md (36)
//   m_j(t) = r(t) A_j sin(2 pi t/T - 2 pi s_j/lambda + phi)       [N m], vertex j between elements j-1 and j, s_j its
//                                                                 arc length
//   c_j += Q_j m_j d,   c_{j-1} -= Q_{j-1} m_j d                  [N m] body; d a lab direction
// With `frame` = "body", d is a direction of the material. m_j then acts as a change of the rest curvature. theory.md
// (36a) A ring's last vertex, j = n, is where it closes. The ends j = 0 and j = n of an open rod are vertices where
// they are clamped, with the A_j of the next one. Source: Gazzola et al. 2018 (snake), in the form of the active matter
// of Parthasarathy et al. 2026.
#pragma once

#include "loads/vertex_wave.hpp"
#include "rod/shape_places.hpp"
#include "skein/core/fields.hpp"
#include "skein/core/index.hpp"
#include "skein/loads/load.hpp"

#include <algorithm>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

namespace skein {

struct MuscleWave : WaveLoad<MuscleWave> {
    static constexpr std::string_view kind = "muscle_wave", label = "muscles";
    static constexpr bool for_rigid_bodies = false;
    double amplitude = 0; ///< A, N m
    /// A_j/A of every vertex (elements - 1, in a ring elements), or at these places; empty: 1
    std::vector<double> profile;
    std::vector<double> profile_at;   ///< places over the length, rising
    double period = 0;                ///< T, s
    double wavelength = 0;            ///< lambda, m
    double phase = 0;                 ///< phi, rad
    Vec3d direction{0, 0, 1};         ///< d
    LoadFrame frame = LoadFrame::lab; ///< axes of d
    Ramp ramp;

    void fields(FieldVisitor& f) {
        f.visit({.name = "amplitude", .unit = "N m", .text = "A, couple", .required = true}, amplitude);
        f.visit({.name = "profile",
                 .unit = "-",
                 .text = "A over `amplitude` at every inner vertex (elements - 1; a ring: elements, the last at its "
                         "closing point), or at the places `profile_at`; empty: 1"},
                profile);
        f.visit({.name = "profile_at",
                 .unit = "-",
                 .text = "places of `profile` over the length of the rod, in ascending order; linear between them, "
                         "constant outside; such a profile fits any number of elements"},
                profile_at);
        f.visit({.name = "period", .unit = "s", .text = "T", .required = true, .above = 0}, period);
        f.visit({.name = "wavelength",
                 .unit = "m",
                 .text = "lambda; negative: the wave travels towards the start",
                 .required = true},
                wavelength);
        common_fields(f, *this);
    }
    void check(RodSpecs groups, Objections& objections) const {
        if (wavelength == 0) objections.add("wavelength", "'wavelength' of a muscle_wave cannot be 0");
        check_direction(objections);
        if (!profile_at.empty()) {
            if (profile_at.size() != profile.size())
                objections.add("profile_at", "'profile_at' needs a place for every value of 'profile': it has " +
                                                 std::to_string(profile_at.size()) + ", which has " +
                                                 std::to_string(profile.size()));
            if (std::adjacent_find(profile_at.begin(), profile_at.end(), std::greater_equal<>()) != profile_at.end())
                objections.add("profile_at", "'profile_at' must rise");
            return;
        }
        if (profile.empty()) return;
        for (const RodSpec* rods : groups) {
            objections.length("profile", profile.size(), rods->shape.cells(),
                              std::string("one for each ") +
                                  (rods->shape.closed ? "vertex of the rings" : "inner vertex (elements - 1)") +
                                  " of group '" + rods->name + "'");
        }
    }
    std::string refine(const Shape& was, const Shape& now) {
        if (profile.empty() || !profile_at.empty()) return {};
        profile = between(vertices_of(was), profile, vertices_of(now), was.closed);
        return "'profile' is taken as linear between vertices";
    }

    /// Phase lag of the wave at arc length s, rad.
    double phase_at(double s) const { return 2 * std::numbers::pi / wavelength * s - phase; }
    /// A_j/A of vertex j >= 1, which is at arc length s of a rod of this length.
    double share(int j, double s, double length) const {
        if (profile.empty()) return 1;
        if (profile_at.empty()) return nth(profile, j - 1);
        const auto after = std::lower_bound(profile_at.begin(), profile_at.end(), s / length);
        if (after == profile_at.begin()) return profile.front();
        if (after == profile_at.end()) return profile.back();
        const std::size_t i = to_index(after - profile_at.begin());
        const double way = (s / length - profile_at[i - 1]) / (profile_at[i] - profile_at[i - 1]);
        return (1 - way) * profile[i - 1] + way * profile[i];
    }
    void bind_group(const RodGroup& group) {
        const int n = group.elements(), last = group.cells();
        wave.resize(n, frame);
        double s = 0, length = 0;
        for (const ElementConstants& e : group.element) length += e.rest_length;
        for (int j = 1; j <= last; ++j) {
            s += nth(group.element, j - 1).rest_length;
            wave.set(j % n, amplitude * share(j, s, length), phase_at(s));
        }
        if (last > 0)
            wave.set_ends(group, amplitude * share(1, 0, length), phase_at(0), amplitude * share(last, length, length),
                          phase_at(length));
    }
};

} // namespace skein
