// The discrete equations of Poisson and Helmholtz of a box.                                                  theory.md
// (77), (84)
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/line_transform.hpp"

#include <array>

namespace skein {

/// (sum over directions of second differences + shift) phi = scale f, by what phi does at the ends of lines of each
/// direction.
struct Helmholtz {
    Helmholtz(const FluidGrid& grid, const std::array<LineEnds, 3>& ends)
        : x(grid.cells[0], ends[0]), y(grid.cells[1], ends[1]), z(ends[2]) {}
    /// Of a pressure: no gradient across faces that are no period.
    static Helmholtz of_pressure(const FluidGrid& grid) {
        const auto end = [&](int d) { return grid.periodic(d) ? LineEnds::periodic : LineEnds::gradient_zero; };
        Helmholtz equation(grid, {end(0), end(1), end(2)});
        equation.scale = grid.h * grid.h;
        return equation;
    }

    /// What right sides are multiplied by between transforms there and back.
    double scale_of_coefficients() const { return scale / (x.gain() * y.gain()); }
    /// Of the tridiagonal system along z of coefficients m and j; beyond the last m, of one that has an answer.
    double diagonal(int m, int j) const { return m < x.size() ? x.eigenvalue(m) + y.eigenvalue(j) - 2 + shift : -3; }
    /// Beyond an end along z the value is that of the outer number, its opposite, or 0: that much more in the diagonal.
    double end() const { return z == LineEnds::gradient_zero ? 1 : z == LineEnds::value_zero ? -1 : 0; }
    /// Of `planes` planes up to the upper end, those whose numbers are not known.
    int unknown(int planes) const { return z == LineEnds::faces_zero ? planes - 1 : planes; }
    /// Whether the constant is free.
    bool singular() const {
        const auto free = [](LineEnds ends) { return ends == LineEnds::periodic || ends == LineEnds::gradient_zero; };
        return shift == 0 && free(x.ends()) && free(y.ends()) && free(z);
    }

    LineTransform x, y;
    LineEnds z;
    double shift = 0, scale = 1;
};

} // namespace skein
