// Forces that turn in a plane, on the two end nodes, after a steady pull. theory.md (37)
//   f_0 += F_start u(t),  f_n += F_end u(t)        [N] lab
//   u = steady * nu  for t < hold,  then  cos(p) nu x tau + sin(p) nu,  p = 2 pi (t - hold)/T
// Source: PyElastica's EndpointForcesSinusoidal of its joint cases, where steady = -2 and T = 4 s.
#pragma once

#include "skein/core/fields.hpp"
#include "skein/loads/load.hpp"
#include "skein/tiles/mapping.hpp"

#include <cmath>
#include <numbers>
#include <span>

namespace skein {

struct SinusoidalEndForce {
    static constexpr std::string_view kind = "sinusoidal_end_force", label = "sinusoidal end forces";
    static constexpr bool ignores_motion = true;
    static constexpr bool for_rigid_bodies = false, for_rings = false;
    double start = 0;       ///< F_start, N
    double end = 0;         ///< F_end, N
    Vec3d normal{0, 1, 0};  ///< nu, lab
    Vec3d tangent{0, 0, 1}; ///< tau, lab
    double hold = 0;        ///< s
    double steady = -2;
    double period = 4; ///< T, s

    void fields(FieldVisitor& f) {
        f.visit({.name = "start", .unit = "N", .text = "magnitude of the force on the first node"}, start);
        f.visit({.name = "end", .unit = "N", .text = "magnitude of the force on the last node"}, end);
        f.visit({.name = "normal",
                 .unit = "-",
                 .text = "the force rotates in the plane of `normal` and `normal` x `tangent`, lab frame"},
                normal);
        f.visit({.name = "tangent", .unit = "-", .text = "tangent of the rod at the start, lab frame"}, tangent);
        f.visit({.name = "hold",
                 .unit = "s",
                 .text = "time until which the force is steady, along `normal`",
                 .at_least = 0},
                hold);
        f.visit({.name = "steady", .unit = "-", .text = "ratio of the steady force to the rotating one"}, steady);
        f.visit({.name = "period", .unit = "s", .text = "period of the rotation", .above = 0}, period);
    }
    void check(RodSpecs, Objections& objections) const {
        if (start == 0 && end == 0) objections.add("", "a sinusoidal_end_force needs 'start' or 'end' [N]: both are 0");
        if (hold == 0) objections.unused({"steady"}, "without 'hold' [s]");
        if (parallel(normal, tangent))
            objections.add("normal", "'normal' and 'tangent' are parallel: the force would have no plane to turn in");
    }

    /// u(t), lab.
    Vec3d at(double time) const {
        if (time < hold) return steady * normal;
        const double angle = 2 * std::numbers::pi / period * (time - hold);
        return std::cos(angle) * cross(normal, tangent) + std::sin(angle) * normal;
    }
    void prepare(std::span<const Step> steps) {
        for (const Step& s : steps) direction[s.slot] = at(s.time);
    }
    Vec3d direction[Clock::largest_batch];

    template <int W, class Map = Across<W>> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const {
        Map::add_to_ends(rod, load, start * direction[step.slot], end * direction[step.slot]);
    }
};

} // namespace skein
