// Rod laws: axial force, shear and bending stiffness from strain. Each law with an energy is a struct, which kernels
// take as a template argument. theory.md section 3. The published law has no energy and passes of its own:
// elastica.hpp.
#pragma once

#include "core/logarithm.hpp"
#include "skein/core/vec3.hpp"
#include "skein/rod/rod_group.hpp"

namespace skein {

/// Factors on B where bending and twist have different ones.
template <class P> struct CellFactor {
    P bending, twist; ///< factors about d1 and d2, and about d3

    SKEIN_INLINE friend CellFactor operator*(const CellFactor& f, const P& s) { return {f.bending * s, f.twist * s}; }
    SKEIN_INLINE friend Vec3<P> operator*(const CellFactor& f, const Vec3<P>& v) {
        return {f.bending * v.x, f.bending * v.y, f.twist * v.z};
    }
};
/// Both factors of any law.
template <class P> SKEIN_INLINE CellFactor<P> both_factors(const P& one) { return {one, one}; }
template <class P> SKEIN_INLINE CellFactor<P> both_factors(const CellFactor<P>& f) { return f; }
/// |f v|
template <class P> SKEIN_INLINE P factored_norm(const P& f, const Vec3<P>& v) { return f * norm(v); }
template <class P> SKEIN_INLINE P factored_norm(const CellFactor<P>& f, const Vec3<P>& v) { return norm(f * v); }

/// Law of a section that shrinks as the rod stretches (constant volume). It has the axial force EA(e - e0)/e and the
/// moment B kappa/E^3 of the published model, from an energy:
///   U = sum l0 [EA(e - e0 - e0 ln(e/e0)) + aGA d^2/2] + sum D/2 (kappa-kappa0).B(kappa-kappa0)/E^3
/// It is stable in tension for every e where aG >= E/4.
struct IncompressibleLaw {
    static constexpr bool bending_pulls = true;

    /// n = dWs/dnu [N, body] of element strain nu = Q dx/l0; C: ElementConstants of numbers or of packs.
    template <class C, class P> SKEIN_INLINE static Vec3<P> stress(const C& c, const Vec3<P>& nu) {
        return {P(c.stiffness.x) * (nu.x - P(c.rest_strain.x)), P(c.stiffness.y) * (nu.y - P(c.rest_strain.y)),
                P(c.stiffness.z) * (nu.z - P(c.rest_stretch)) / nu.z};
    }
    /// Factor on B in a cell of dilatation E, from 1/E; `rest_stretch`: e0.
    template <class P, class R> SKEIN_INLINE static P bending_factor(const P& inv_dilatation, const R&) {
        return inv_dilatation * inv_dilatation * inv_dilatation;
    }
    /// Axial force on both elements of a cell from its bending energy, for `strain` kappa - kappa0 and `moment` B
    /// (kappa - kappa0), q their product: -(3/4) q/E^4.
    template <class P, class R> SKEIN_INLINE static P
    bending_tension(const Vec3<P>& strain, const Vec3<P>& moment, const P& factor, const P& inv_dilatation, const R&) {
        return P(-0.75) * dot(strain, moment) * (factor * inv_dilatation);
    }
    /// Addition to dn_3/de of an element from the derivative of that force by the dilatation, N: 3 q/E^5.
    template <class P, class R> static P bending_stiffness(const Vec3<P>& strain, const Vec3<P>& moment,
                                                           const P& factor, const P& inv_dilatation, const R&) {
        return P(3.0) * dot(strain, moment) * factor * inv_dilatation * inv_dilatation;
    }
    /// dn_3/de [N] without bending.
    template <class C, class P> static P stretch_stiffness(const C& c, P e) {
        return P(c.stiffness.z * c.rest_stretch) / (e * e);
    }
    /// Axial energy per rest length, J/m.
    template <int W> SKEIN_INLINE static Pack<W> stretch_energy(const ElementConstants& c, const Pack<W>& e) {
        return Pack<W>(c.stiffness.z * c.rest_stretch) *
               less_log(Pack<W>(1 / c.rest_stretch) * (e - Pack<W>(c.rest_stretch)));
    }
};

/// Law of a section and stiffness as at rest:
///   U = sum l0 [EA(e - e0)^2 + aGA d^2]/2 + sum D/2 (kappa-kappa0).B(kappa-kappa0)
/// It is 16 % off the published moment at 5 % stretch, and loses stability in tension at e0/(1 - aG/E).
struct LinearLaw {
    static constexpr bool bending_pulls = false;

    template <class C, class P> SKEIN_INLINE static Vec3<P> stress(const C& c, const Vec3<P>& nu) {
        return {P(c.stiffness.x) * (nu.x - P(c.rest_strain.x)), P(c.stiffness.y) * (nu.y - P(c.rest_strain.y)),
                P(c.stiffness.z) * (nu.z - P(c.rest_stretch))};
    }
    template <class P, class R> SKEIN_INLINE static P bending_factor(const P&, const R&) { return P(1.0); }
    template <class C, class P> static P stretch_stiffness(const C& c, P) { return P(c.stiffness.z); }
    template <int W> SKEIN_INLINE static Pack<W> stretch_energy(const ElementConstants& c, const Pack<W>& e) {
        const Pack<W> strain = e - Pack<W>(c.rest_stretch);
        return Pack<W>(0.5 * c.stiffness.z) * strain * strain;
    }
};

/// Law of incompressible neo-Hookean sections, of constant volume, with lambda = e/e0 and u = e0/E (of a cell). W is a
/// third of E A (lambda^2/2 + 1/lambda - 3/2). Fibres in uniaxial tension make the factor (u + 2 u^4)/3 on bending, and
/// the sheared cylinder u on twist, over B at rest. theory.md (11b)-(11d)
struct NeoHookeanLaw {
    static constexpr bool bending_pulls = true;

    template <class C, class P> SKEIN_INLINE static Vec3<P> stress(const C& c, const Vec3<P>& nu) {
        const P e0(c.rest_stretch), &e = nu.z;
        // (E A/3 e0)(lambda - 1/lambda^2), without the difference of numbers near 1
        return {P(c.stiffness.x) * (nu.x - P(c.rest_strain.x)), P(c.stiffness.y) * (nu.y - P(c.rest_strain.y)),
                P(c.stiffness.z) * (e - e0) * fma(e, e + e0, e0 * e0) / (P(3.0) * (e0 * e0) * (e * e))};
    }
    template <class P, class R>
    SKEIN_INLINE static CellFactor<P> bending_factor(const P& inv_dilatation, const R& rest_stretch) {
        const P u = P(rest_stretch) * inv_dilatation, u_squared = u * u;
        return {P(1.0 / 3) * fma(u_squared, P(2.0) * u_squared, u), u};
    }
    /// -(1/4E) ((u + 8 u^4) q_bending/3 + u q_twist)
    template <class P, class R> SKEIN_INLINE static P bending_tension(const Vec3<P>& strain, const Vec3<P>& moment,
                                                                      const CellFactor<P>&, const P& inv_dilatation,
                                                                      const R& rest_stretch) {
        const P u = P(rest_stretch) * inv_dilatation, u_squared = u * u;
        const P bending = P(1.0 / 3) * fma(u_squared, P(8.0) * u_squared, u);
        return P(-0.25) * inv_dilatation * work(strain, moment, bending, u);
    }
    /// (1/4E^2) ((2 u + 40 u^4) q_bending/3 + 2 u q_twist)
    template <class P, class R> static P bending_stiffness(const Vec3<P>& strain, const Vec3<P>& moment,
                                                           const CellFactor<P>&, const P& inv_dilatation,
                                                           const R& rest_stretch) {
        const P u = P(rest_stretch) * inv_dilatation, u_squared = u * u;
        const P bending = P(2.0 / 3) * fma(u_squared, P(20.0) * u_squared, u);
        return P(0.25) * inv_dilatation * inv_dilatation * work(strain, moment, bending, u + u);
    }
    template <class C, class P> static P stretch_stiffness(const C& c, P e) {
        const P e0(c.rest_stretch);
        return P(c.stiffness.z) * (P(1.0) / (e0 * e0) + P(2.0) * e0 / (e * e * e)) * P(1.0 / 3);
    }
    template <int W> SKEIN_INLINE static Pack<W> stretch_energy(const ElementConstants& c, const Pack<W>& e) {
        const Pack<W> d = Pack<W>(1 / c.rest_stretch) * (e - Pack<W>(c.rest_stretch)); // lambda - 1
        return Pack<W>(c.stiffness.z / 6) * (d * d) * (d + Pack<W>(3.0)) / (d + Pack<W>(1.0));
    }

private:
    template <class P>
    SKEIN_INLINE static P work(const Vec3<P>& strain, const Vec3<P>& moment, const P& bending, const P& twist) {
        return fma(bending, fma(strain.x, moment.x, strain.y * moment.y), twist * (strain.z * moment.z));
    }
};

/// Passes that set internal loads, in the order of Law.
inline constexpr std::string_view elastic_names[] = {"elastic (incompressible)", "elastic (linear)",
                                                     "elastica (as published)", "elastic (neo-Hookean)"};

/// Calls f(Law{}) for a law that has an energy; callers must sort out others.
template <class F> auto with_energy_law(Law law, F&& f) {
    if (law == Law::linear) return f(LinearLaw{});
    return law == Law::neo_hookean ? f(NeoHookeanLaw{}) : f(IncompressibleLaw{});
}

} // namespace skein
