// Energy, momentum and extremes of a flow, by row of cells.
#pragma once

#include "fluid/flow.hpp"
#include "fluid/sweeps.hpp"
#include "skein/core/index.hpp"

#include <algorithm>

namespace skein {

inline double sum_of_lanes(const Pack<8>& p) {
    double sum = 0;
    for (int l = 0; l < 8; ++l) sum += p[l];
    return sum;
}
inline double largest_of_lanes(const Pack<8>& p) {
    double most = p[0];
    for (int l = 1; l < 8; ++l) most = std::max(most, p[l]);
    return most;
}

/// Figures of row j of plane k.
inline FlowFigures row_figures(const FlowConstants& constants, const FieldLayout& layout,
                               const Three<const double*>& velocity, int j, int k) {
    using P = Pack<8>;
    const double h = constants.grid.h, mass = constants.density * h * h * h;
    const std::ptrdiff_t r = layout.row, p = layout.plane;
    Three<P> sum{P(0.0), P(0.0), P(0.0)};
    P squares(0.0), loss(0.0), vorticity(0.0), divergence(0.0), speed(0.0);
    for (int i = 0; i < layout.nx; i += 8) {
        const std::ptrdiff_t at = layout.at(i, j, k);
        const auto of = [&](const P& value) { return first_lanes(value, layout.nx - i); };
        P here_speed(0.0);
        for (std::size_t c = 0; c < 3; ++c) {
            const double* f = velocity[c] + at;
            const P here = of(load<8>(f));
            sum[c] += here;
            here_speed += abs(here);
            squares = fma(here, here, squares);
            loss = fma(here, of(fms(P(6.0), here, around(layout, f))), loss);
        }
        speed = max(speed, here_speed);
        const double *const u = velocity[0] + at, *const v = velocity[1] + at, *const w = velocity[2] + at;
        const P x = of((load<8>(w + r) - load<8>(w)) - (load<8>(v + p) - load<8>(v))),
                y = of((load<8>(u + p) - load<8>(u)) - (load<8>(w + 1) - load<8>(w))),
                z = of((load<8>(v + 1) - load<8>(v)) - (load<8>(u + r) - load<8>(u)));
        vorticity += fma(x, x, fma(y, y, z * z));
        divergence = max(divergence, of(abs(outflow_of(layout, {u, v, w}))));
    }
    return {.kinetic_energy = 0.5 * mass * sum_of_lanes(squares),
            .enstrophy = 0.5 * h * sum_of_lanes(vorticity),
            .dissipation = mass * constants.kinematic_viscosity * sum_of_lanes(loss) / (h * h),
            .divergence = largest_of_lanes(divergence) / h,
            .speed = largest_of_lanes(speed),
            .momentum = mass * Vec3d{sum_of_lanes(sum[0]), sum_of_lanes(sum[1]), sum_of_lanes(sum[2])}};
}

} // namespace skein
