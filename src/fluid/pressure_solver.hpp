// Iterative solver of Poisson's equation for the pressure on grids of boxes with edges that vary along each direction.
// It is a library of its own, which the first solver loads, so that only runs that use it need PETSc. theory.md (83)
#pragma once

#include "parallel/communicator.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Boxes in rows: cell (i, j, k) has the edges width[0][i], width[1][j] and width[2][k].
struct TensorGrid {
    std::array<std::vector<double>, 3> width; ///< m
    std::array<bool, 3> periodic{};           ///< false: no gradient across both ends
};

class PressureSolver {
public:
    virtual ~PressureSolver() = default;
    /// Finds phi of mean 0 whose second differences, each over its own spacing, add up to f [phi/m^2] less its mean.
    /// Cells are those of this rank's planes by slab_of(), x fastest, then y. Returns the reason for a failure on all
    /// ranks, or an empty text. Collective.
    virtual std::string solve(std::span<const double> f, std::span<double> phi) = 0;
    /// Size of matrices and vectors on this rank.
    virtual std::size_t bytes() const = 0;
};

/// Makes a solver by conjugate gradients, preconditioned by a multigrid cycle, until the residual is `tolerance` times
/// f (root mean squares over the volume of cells). Bits depend on the number of ranks. Throws InputError in programs
/// built without it, without its library, and if that fails. Collective.
std::unique_ptr<PressureSolver> make_multigrid(const Communicator& comm, const TensorGrid& grid, double tolerance);

} // namespace skein
