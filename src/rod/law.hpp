// Rod laws: how axial force, shear and bending stiffness follow from strain. One struct per law with an energy; kernels take it as
// a template argument. theory.md section 3. (The published law has no energy and passes of its own: elastica.hpp.)
#pragma once

#include "core/logarithm.hpp"
#include "skein/core/vec3.hpp"
#include "skein/rod/rod_group.hpp"

namespace skein {

/// Section shrinks as the rod stretches (constant volume); the axial force EA(e - e0)/e and moment B kappa/E^3 of the published
/// model, from an energy:  U = sum l0 [EA(e - e0 - e0 ln(e/e0)) + aGA d^2/2] + sum D/2 (kappa-kappa0).B(kappa-kappa0)/E^3.
/// Stable in tension for every e where aG >= E/4.
struct IncompressibleLaw {
    static constexpr bool bending_pulls = true;

    /// n = dWs/dnu [N, body] of element strain nu = Q dx/l0; C: ElementConstants of numbers or of packs.
    template <class C, class P> SKEIN_INLINE static Vec3<P> stress(const C& c, const Vec3<P>& nu) {
        return {P(c.stiffness.x) * (nu.x - P(c.rest_strain.x)), P(c.stiffness.y) * (nu.y - P(c.rest_strain.y)),
                P(c.stiffness.z) * (nu.z - P(c.rest_stretch)) / nu.z};
    }
    /// Factor on B in a cell of dilatation E, from 1/E.
    template <class P> SKEIN_INLINE static P bending_factor(P inv_dilatation) {
        return inv_dilatation * inv_dilatation * inv_dilatation;
    }
    /// Axial force on both elements of a cell from its bending energy, q = (kappa-kappa0).B(kappa-kappa0): -(3/4) q/E^4.
    template <class P> SKEIN_INLINE static P bending_tension(P q, P bending_factor, P inv_dilatation) {
        return P(-0.75) * q * (bending_factor * inv_dilatation);
    }
    /// dn_3/de [N] without bending.
    template <class C, class P> static P stretch_stiffness(const C& c, P e) { return P(c.stiffness.z * c.rest_stretch) / (e * e); }
    /// Axial energy per rest length, J/m.
    template <int W> SKEIN_INLINE static Pack<W> stretch_energy(const ElementConstants& c, const Pack<W>& e) {
        return Pack<W>(c.stiffness.z * c.rest_stretch) * less_log(Pack<W>(1 / c.rest_stretch) * (e - Pack<W>(c.rest_stretch)));
    }
};

/// Section and stiffness as at rest:  U = sum l0 [EA(e - e0)^2 + aGA d^2]/2 + sum D/2 (kappa-kappa0).B(kappa-kappa0).
/// 16 % off the published moment at 5 % stretch. Loses stability in tension at e0/(1 - aG/E).
struct LinearLaw {
    static constexpr bool bending_pulls = false;

    template <class C, class P> SKEIN_INLINE static Vec3<P> stress(const C& c, const Vec3<P>& nu) {
        return {P(c.stiffness.x) * (nu.x - P(c.rest_strain.x)), P(c.stiffness.y) * (nu.y - P(c.rest_strain.y)),
                P(c.stiffness.z) * (nu.z - P(c.rest_stretch))};
    }
    template <class P> SKEIN_INLINE static P bending_factor(P) { return P(1.0); }
    template <class C, class P> static P stretch_stiffness(const C& c, P) { return P(c.stiffness.z); }
    template <int W> SKEIN_INLINE static Pack<W> stretch_energy(const ElementConstants& c, const Pack<W>& e) {
        const Pack<W> strain = e - Pack<W>(c.rest_stretch);
        return Pack<W>(0.5 * c.stiffness.z) * strain * strain;
    }
};

/// Passes that set internal loads, in the order of Law.
inline constexpr std::string_view elastic_names[] = {"elastic (incompressible)", "elastic (linear)", "elastica (as published)"};

/// Calls f(Law{}) for a law that has an energy; those that have none are for the caller to tell apart.
template <class F> auto with_energy_law(Law law, F&& f) { return law == Law::linear ? f(LinearLaw{}) : f(IncompressibleLaw{}); }

} // namespace skein
