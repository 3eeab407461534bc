// Drag of a thin rod in a viscous fluid at rest, to leading order in 1/ln(L/r): no flow is solved for.   theory.md (38)
//   F_k = -4 pi mu l'/ln(L'/r) (1 - t t^T/2) v_k,  half to each node of element k        [N] lab
//   l', t: length and tangent now; L' = sum of l'; r = sqrt(V/(pi l')); v_k = (m_k v_k + m_{k+1} v_{k+1})/(m_k + m_{k+1})
// Source: Cox 1970 (J. Fluid Mech. 44, 791), Gazzola et al. 2018. The velocity is that of before the kick, so this is an explicit
// load: first order in the step, and stable only while (step) x (drag rate) < 2: the plan counts it among the limits. Damping of
// kind "physical" has neither fault. In a ring node n is node 0.
// Cost: 60 flop per element, one square root and one division; a logarithm per lane.
#pragma once

#include "core/fields.hpp"
#include "rod/mapping.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace skein {

struct SlenderBodyDrag {
    static constexpr std::string_view kind = "slender_body_drag";
    static constexpr bool needs_whole_rods = true; ///< L' is a sum along the rod
    double viscosity = 0;                          ///< mu, Pa s

    void fields(FieldVisitor& f) {
        f.visit({.name = "viscosity",
                 .unit = "Pa s",
                 .text = "of the fluid, at rest; an explicit load, whose rate the plan counts among the limits of the step",
                 .required = true,
                 .above = 0},
                viscosity);
    }

    std::vector<double> share; ///< m_k/(m_k + m_{k+1}), [n]

    void bind_group(const RodGroup& group) {
        for (int k = 0; k < group.elements(); ++k) share.push_back(mass(group, k) / (mass(group, k) + mass(group, k + 1)));
    }

    struct Rate {
        double value; ///< 1/s
        int element;
    };
    /// The largest rate of decay of a velocity at the rest lengths, bounded from above by the sum along a node's row: half of the
    /// drag of both its elements over its mass. theory.md (38)
    Rate largest_rate(const RodGroup& group) const {
        const int n = group.elements();
        const auto half_drag = [&](int k) {
            const ElementConstants& e = group.element[static_cast<std::size_t>(k)];
            return 2 * std::numbers::pi * viscosity * e.rest_length / std::log(group.spec().shape.length / e.radius);
        };
        Rate largest{0, 0};
        for (int i = 0; i <= n; ++i) {
            double drag = 0;
            if (i > 0 || group.closed()) drag += half_drag((i + n - 1) % n);
            if (i < n || group.closed()) drag += half_drag(i % n);
            const double rate = drag / mass(group, i);
            if (rate > largest.value) largest = {rate, std::min(i, n - 1)};
        }
        return largest;
    }

    template <int W, class Map = Across<W>> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const {
        using P = Pack<W>;
        P total(0.0);
        for (int k = 0; k < rod.n; ++k) total = total + norm(rod.slot[k + 1].position - rod.slot[k].position);
        for (int k = 0; k < rod.n; ++k) {
            const Vec3<P> edge = rod.slot[k + 1].position - rod.slot[k].position;
            const P squared = dot(edge, edge), length = sqrt(squared);
            const double before = share[static_cast<std::size_t>(k)];
            const Vec3<P> v = fma(P(before), rod.slot[k].velocity, P(1 - before) * rod.slot[k + 1].velocity);
            // ln(L'/r) = ln(L'^2/r^2)/2
            P slenderness = total * total * length * P(std::numbers::pi / rod.element[k].volume);
            for (int i = 0; i < W; ++i) slenderness.set(i, 0.5 * std::log(slenderness[i]));
            const Vec3<P> across = v - (P(0.5) * dot(edge, v) / squared) * edge;
            const Vec3<P> half = (P(-2 * std::numbers::pi * viscosity) * length / slenderness) * across;
            load[k].force += half;
            load[k + 1].force += half;
        }
    }

private:
    static double mass(const RodGroup& group, int i) {
        return group.node_mass[static_cast<std::size_t>(group.closed() ? i % group.elements() : i)];
    }
};

} // namespace skein
