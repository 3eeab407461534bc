// Rates and velocities of a row of cells within a stage. Velocity u of cell (i, j, k) is at its upper face across x, v
// across y, w across z. theory.md (75), (76)
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/lanes.hpp"

#include <array>

namespace skein {

/// Quantities of three components.
template <class T> using Three = std::array<T, 3>;

/// Change of velocities in a stage: rate N + last_rate N_last - pressure grad p + push.
struct StageFactors {
    double rate, last_rate, pressure;
    Three<double> push; ///< impulse of the acceleration over mass, m/s
};

/// Viscosity in the rates, or in the velocity at the begin of a half implicit stage.
enum class Viscosity { of_rates, of_velocity };

/// Computes rates of viscosity and of convection, in divergence form, which conserves kinetic energy. Then it computes
/// the velocities after the stage. `rate` has the rates of the last stage before, and those of this stage after. Cost:
/// 120 flop and 13 numbers in memory per cell.
template <Viscosity viscosity> class StageSweep {
public:
    using P = Pack<8>;
    /// `diffusion` is the factor of second differences: 1/s in rates, 1 in velocities.
    StageSweep(const FieldLayout& layout, double h, double diffusion, const StageFactors& factors)
        : row_(layout.row), plane_(layout.plane), quarter_(0.25 / h), diffusion_(diffusion), factors_(factors),
          gradient_(factors.pressure / h) {}

    /// Sweeps eight cells from these pointers on.
    SKEIN_INLINE void run(const Three<const double*>& velocity, const double* pressure, const Three<double*>& rate,
                          const Three<double*>& out) const {
        const double *const u = velocity[0], *const v = velocity[1], *const w = velocity[2];
        const std::ptrdiff_t r = row_, p = plane_;
        const auto at = [](const double* from) __attribute__((always_inline)) { return load<8>(from); };
        const P u0 = at(u), ue = at(u + 1), uw = at(u - 1), un = at(u + r), us = at(u - r), ut = at(u + p),
                ub = at(u - p);
        const P v0 = at(v), ve = at(v + 1), vw = at(v - 1), vn = at(v + r), vs = at(v - r), vt = at(v + p),
                vb = at(v - p);
        const P w0 = at(w), we = at(w + 1), ww = at(w - 1), wn = at(w + r), ws = at(w - r), wt = at(w + p),
                wb = at(w - p);
        // Four times the products at edges and centres; both components at an edge use the same product.
        const P uv = (u0 + un) * (v0 + ve), uv_west = (uw + at(u + r - 1)) * (vw + v0),
                uv_south = (us + u0) * (vs + at(v - r + 1));
        const P uw_ = (u0 + ut) * (w0 + we), uw_west = (uw + at(u + p - 1)) * (ww + w0),
                uw_below = (ub + u0) * (wb + at(w - p + 1));
        const P vw_ = (v0 + vt) * (w0 + wn), vw_south = (vs + at(v + p - r)) * (ws + w0),
                vw_below = (vb + v0) * (wb + at(w - p + r));
        const auto square = [](const P& a) __attribute__((always_inline)) { return a * a; };
        const P quarter(quarter_), diffusion(diffusion_), six(6.0);
        const auto rate_of = [&](const P& flux, const P& around, const P& here) __attribute__((always_inline)) {
            if constexpr (viscosity == Viscosity::of_velocity) return -(quarter * flux);
            else return fma(diffusion, fnma(six, here, around), -(quarter * flux));
        };
        const auto before_of = [&](const P& around, const P& here) __attribute__((always_inline)) {
            if constexpr (viscosity == Viscosity::of_velocity) return fma(diffusion, fnma(six, here, around), here);
            else return here;
        };
        const P around_u = (ue + uw) + (un + us) + (ut + ub), around_v = (ve + vw) + (vn + vs) + (vt + vb),
                around_w = (we + ww) + (wn + ws) + (wt + wb);
        const P of_u = rate_of((square(u0 + ue) - square(uw + u0)) + (uv - uv_south) + (uw_ - uw_below), around_u, u0),
                of_v = rate_of((uv - uv_west) + (square(v0 + vn) - square(vs + v0)) + (vw_ - vw_below), around_v, v0),
                of_w = rate_of((uw_ - uw_west) + (vw_ - vw_south) + (square(w0 + wt) - square(wb + w0)), around_w, w0);
        const P p0 = at(pressure), gradient(gradient_);
        const auto put = [&](std::size_t c, const P& now, const P& before, const P& ahead)
            __attribute__((always_inline)) {
            const P last = at(rate[c]);
            store(rate[c], now);
            P to = before + P(factors_.push[c]);
            to = fma(P(factors_.rate), now, to);
            to = fma(P(factors_.last_rate), last, to);
            store(out[c], fnma(gradient, ahead - p0, to));
        };
        put(0, of_u, before_of(around_u, u0), at(pressure + 1));
        put(1, of_v, before_of(around_v, v0), at(pressure + r));
        put(2, of_w, before_of(around_w, w0), at(pressure + p));
    }

private:
    std::ptrdiff_t row_, plane_;
    double quarter_, diffusion_;
    StageFactors factors_;
    double gradient_;
};

/// Sum of the six neighbours of each of eight cells.
SKEIN_INLINE Pack<8> around(const FieldLayout& layout, const double* f) {
    const std::ptrdiff_t r = layout.row, p = layout.plane;
    return (load<8>(f + 1) + load<8>(f - 1)) + (load<8>(f + r) + load<8>(f - r)) + (load<8>(f + p) + load<8>(f - p));
}

/// Sum of velocity differences over each of eight cells: h times the divergence.
SKEIN_INLINE Pack<8> outflow_of(const FieldLayout& layout, const Three<const double*>& velocity) {
    return (load<8>(velocity[0]) - load<8>(velocity[0] - 1)) +
           (load<8>(velocity[1]) - load<8>(velocity[1] - layout.row)) +
           (load<8>(velocity[2]) - load<8>(velocity[2] - layout.plane));
}

} // namespace skein
