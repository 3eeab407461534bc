// Eigenvalues of Q(lambda) = lambda^2 M + lambda C + K that are smallest in size, with their vectors.  theory.md (108)
//   unit       of rates: lambda = unit mu, where mu of the slowest motions is about 1
//   operator   of pairs (x, v) with v = mu x about the shift mu = 1, one real factor of Q for all steps:
//                q = -Q(1)^-1 (M v + C x + M x),  (x, v) -> (q, x + q),  eigenvalues 1/(mu - 1)
//   subspace   of Krylov by several vectors at a time, for eigenvalues that are alike, orthonormal in the energy
#pragma once

#include "equilibrium/factor.hpp"

#include <complex>
#include <vector>

namespace skein {

/// Matrices of small motions M q'' + C q' + K q = 0.
struct SmallMotions {
    const Stiffness &mass, &damping, &stiffness;
    bool symmetric; ///< all of them
};

struct ExponentPair {
    std::complex<double> exponent; ///< lambda, 1/s; of two conjugate ones that with a positive imaginary part
    Eigen::VectorXcd shape;
};

/// The `count` smallest beside as many `zeros`, which are left out; fewer where there are no more. Empty where the
/// iteration does not converge.
std::vector<ExponentPair> smallest_exponents(const SmallMotions& motions, double unit, Eigen::Index count,
                                             Eigen::Index zeros);

} // namespace skein
