#include "fluid/slab_coupling.hpp"

#include "skein/core/index.hpp"

#include <vector>

namespace skein {

std::int64_t coupling_coefficients(const FluidGrid& grid, int ranks) {
    const auto eigenvalues = [&](int d) {
        const int n = nth(grid.cells, d);
        std::vector<double> all;
        for (int k = 0; k < n; ++k)
            all.push_back(second_difference(n, grid.periodic(d) ? LineEnds::periodic : LineEnds::gradient_zero, k));
        return all;
    };
    const std::vector<double> x = eigenvalues(0), y = eigenvalues(1);
    std::int64_t count = 0;
    for (const double of_x : x)
        for (const double of_y : y) count += couples_slabs(of_x + of_y, grid.cells[2] / ranks);
    return count;
}

} // namespace skein
