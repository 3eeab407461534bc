// Drag of a thin rod in a viscous fluid at rest, to leading order in 1/ln(L/r): no flow is solved for.   theory.md (38)
//   F_k = -4 pi mu l'/ln(L'/r) (1 - t t^T/2) v_k,  half to each node of element k        [N] lab
//   l', t: length and tangent now; L' = sum of l'; r = sqrt(V/(pi l')); v_k = (m_k v_k + m_{k+1} v_{k+1})/(m_k + m_{k+1})
// Source: Cox 1970 (J. Fluid Mech. 44, 791), Gazzola et al. 2018. The velocity is that of before the kick, so this is an explicit
// load: first order in the step, and stable only while (step) x (drag rate) < 2. Damping of kind "physical" has neither fault.
// Cost: 60 flop per element, one square root and one division; a logarithm per lane.
#pragma once

#include "core/fields.hpp"
#include "rod/tile.hpp"

#include <cmath>
#include <numbers>

namespace skein {

struct SlenderBodyDrag {
    static constexpr std::string_view kind = "slender_body_drag";
    double viscosity = 0; ///< mu, Pa s

    void fields(FieldVisitor& f) {
        f.visit({.name = "viscosity", .unit = "Pa s", .text = "of the fluid, at rest; an explicit load: keep the step well below the inverse drag rate",
                 .required = true, .above = 0}, viscosity);
    }

    template <int W> void add(const RodTile<W>& rod, SlotLoad<W>* load, const Step&) const {
        using P = Pack<W>;
        const double* mass = rod.group->node_mass.data();
        P total(0.0);
        for (int k = 0; k < rod.n; ++k) total = total + norm(rod.slot[k + 1].position - rod.slot[k].position);
        for (int k = 0; k < rod.n; ++k) {
            const Vec3<P> edge = rod.slot[k + 1].position - rod.slot[k].position;
            const P squared = dot(edge, edge), length = sqrt(squared);
            const double inv_mass = 1 / (mass[k] + mass[k + 1]);
            const Vec3<P> v = fma(P(mass[k] * inv_mass), rod.slot[k].velocity, P(mass[k + 1] * inv_mass) * rod.slot[k + 1].velocity);
            // ln(L'/r) = ln(L'^2/r^2)/2
            P slenderness = total * total * length * P(std::numbers::pi / rod.element[k].volume);
            for (int i = 0; i < W; ++i) slenderness.set(i, 0.5 * std::log(slenderness[i]));
            const Vec3<P> across = v - (P(0.5) * dot(edge, v) / squared) * edge;
            const Vec3<P> half = (P(-2 * std::numbers::pi * viscosity) * length / slenderness) * across;
            load[k].force += half;
            load[k + 1].force += half;
        }
    }
};

} // namespace skein
