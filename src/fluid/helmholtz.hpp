// Discrete equations of Poisson and Helmholtz in a box. theory.md (77), (84)
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/line_transform.hpp"

#include <array>

namespace skein {

/// (sum over directions of second differences + shift) phi = scale f, with conditions at the ends of lines.
struct Helmholtz {
    Helmholtz(const FluidGrid& grid, const std::array<LineEnds, 3>& ends)
        : x(grid.cells[0], ends[0]), y(grid.cells[1], ends[1]), z(ends[2]) {}
    /// Equation of a pressure, without gradient across faces that are not periodic.
    static Helmholtz of_pressure(const FluidGrid& grid) {
        const auto end = [&](int d) { return grid.periodic(d) ? LineEnds::periodic : LineEnds::gradient_zero; };
        Helmholtz equation(grid, {end(0), end(1), end(2)});
        equation.scale = grid.h * grid.h;
        return equation;
    }

    /// Factor of right sides between both transforms.
    double scale_of_coefficients() const { return scale / (x.gain() * y.gain()); }
    /// Diagonal of the system along z for modes m and j. Beyond the last m it makes a solvable system.
    double diagonal(int m, int j) const { return m < x.size() ? x.eigenvalue(m) + y.eigenvalue(j) - 2 + shift : -3; }
    /// Addition to the diagonal at an end along z, beyond which the value is the outer number, its opposite, or 0.
    double end() const { return z == LineEnds::gradient_zero ? 1 : z == LineEnds::value_zero ? -1 : 0; }
    /// Number of unknown planes of `planes` ones up to the upper end.
    int unknown(int planes) const { return z == LineEnds::faces_zero ? planes - 1 : planes; }
    /// True if the constant is free.
    bool singular() const {
        const auto free = [](LineEnds ends) { return ends == LineEnds::periodic || ends == LineEnds::gradient_zero; };
        return shift == 0 && free(x.ends()) && free(y.ends()) && free(z);
    }

    LineTransform x, y;
    LineEnds z;
    double shift = 0, scale = 1;
};

} // namespace skein
