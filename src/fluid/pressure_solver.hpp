// Poisson's equation of the pressure on a grid of boxes whose edges may vary along each direction, solved by
// iterations: the general path beside FastHelmholtz. What solves it is a library of its own, loaded when the first
// solver is made, so that only runs that ask for it see PETSc. theory.md (83)
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
    std::array<bool, 3> periodic{};           ///< else there is no gradient across both ends
};

class PressureSolver {
public:
    virtual ~PressureSolver() = default;
    /// phi of mean 0 whose sum of second differences, each over its own spacing, is f [phi/m^2] less its mean. Cells of
    /// this rank, x fastest, then y: the planes of slab_of(). Returns why there is no answer, the same on all ranks;
    /// empty: there is one. Collective.
    virtual std::string solve(std::span<const double> f, std::span<double> phi) = 0;
    /// Of matrices and vectors, on this rank.
    virtual std::size_t bytes() const = 0;
};

/// Conjugate gradients with a multigrid cycle before each step, until the residual is `tolerance` times f (root mean
/// squares over the volume of the cells). Bits depend on the number of ranks. Throws InputError where this program was
/// built without it, where its library is not found, and where that refuses. Collective.
std::unique_ptr<PressureSolver> make_multigrid(const Communicator& comm, const TensorGrid& grid, double tolerance);

} // namespace skein
