// Rod laws over a step from one strain to another: forces whose work is the change of energy, without a remainder.
// Quadratic energies have the stress of the mean strain. Others have difference quotients in its place, symmetric in
// both ends, and exact where these agree.   theory.md (121)
#pragma once

#include "core/logarithm.hpp"
#include "mechanics/law.hpp"

#include <cmath>

namespace skein {

/// Energies of bending and of twist of a cell, at both ends of a step on the mean.
template <class P> struct CellEnergies {
    P bending, twist; ///< (kappa - kappa0).B(kappa - kappa0) about d1 and d2, and about d3; N
};

namespace detail {
template <int W> [[gnu::noinline, gnu::cold]] void inverse_tangent_rarely(const Pack<W>& z, Pack<W>& excess) {
    for (int i = 0; i < W; ++i)
        if (!(z[i] * z[i] <= small_log_argument)) excess.set(i, std::atanh(z[i]) / z[i] - 1);
}
} // namespace detail

/// The axial force of a law and what bending adds to it.
template <class Law> struct MeanLaw;

template <> struct MeanLaw<LinearLaw> {
    template <class P> static P axial(const ElementConstants& c, const P& from, const P& to) {
        return P(c.stiffness.z) * (P(0.5) * (from + to) - P(c.rest_stretch));
    }
};

template <> struct MeanLaw<IncompressibleLaw> {
    /// E A (1 - e0 ln(to/from)/(to - from))
    template <int W> static Pack<W> axial(const ElementConstants& c, const Pack<W>& from, const Pack<W>& to) {
        using P = Pack<W>;
        const P sum = from + to, mean = P(0.5) * sum, z = (to - from) / sum, squared = z * z;
        P excess = squared * polynomial(squared, detail::inverse_odd); // of artanh(z)/z over 1
        if (any(!(squared <= P(detail::small_log_argument)))) [[unlikely]]
            detail::inverse_tangent_rarely(z, excess);
        return P(c.stiffness.z) * fnma(P(c.rest_stretch), excess, mean - P(c.rest_stretch)) / mean;
    }
    /// A quarter of the difference quotient of the energy by the dilatation; `from` and `to`: 1/E.
    template <class P> static P tension(const CellEnergies<P>& q, const P& from, const P& to, double) {
        const P product = from * to;
        return P(-0.25) * (q.bending + q.twist) * product * fma(from, from, fma(to, to, product));
    }
};

template <> struct MeanLaw<NeoHookeanLaw> {
    template <class P> static P axial(const ElementConstants& c, const P& from, const P& to) {
        const P e0(c.rest_stretch);
        return P(c.stiffness.z / 3) * (P(0.5) * (from + to) / (e0 * e0) - e0 / (from * to));
    }
    template <class P> static P tension(const CellEnergies<P>& q, const P& from, const P& to, double rest_stretch) {
        const P e0(rest_stretch), u0 = e0 * from, u1 = e0 * to;
        const P bending = P(1.0 / 3) * fma(P(2.0) * (u0 + u1), fma(u0, u0, u1 * u1), P(1.0));
        return P(-0.25) * (from * u1) * fma(bending, q.bending, q.twist);
    }
};

/// Stress of an element, body, N.
template <class Law, int W>
Vec3<Pack<W>> mean_stress(const ElementConstants& c, const Vec3<Pack<W>>& from, const Vec3<Pack<W>>& to) {
    using P = Pack<W>;
    const P half(0.5);
    return {P(c.stiffness.x) * fms(half, from.x + to.x, P(c.rest_strain.x)),
            P(c.stiffness.y) * fms(half, from.y + to.y, P(c.rest_strain.y)), MeanLaw<Law>::axial(c, from.z, to.z)};
}

/// Factors on B of a cell on the mean; `from` and `to`: 1/E.
template <class Law, class P> CellFactor<P> mean_factor(const P& from, const P& to, double rest_stretch) {
    const CellFactor<P> a = both_factors(Law::bending_factor(from, rest_stretch)),
                        b = both_factors(Law::bending_factor(to, rest_stretch));
    return {P(0.5) * (a.bending + b.bending), P(0.5) * (a.twist + b.twist)};
}

} // namespace skein
