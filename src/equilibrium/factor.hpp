// Factors of stiffnesses: L D L^T by bands where unknowns are coupled to their neighbours alone, Eigen's sparse L D L^T
// where rods are coupled to each other, and Eigen's sparse LU where the stiffness is not symmetric. The signs of D
// count the directions in which the energy falls (Sylvester's law of inertia).
#pragma once

#include "parallel/communicator.hpp"

#include <Eigen/SparseCore>

#include <cmath>
#include <memory>
#include <string_view>
#include <vector>

namespace skein {

using Stiffness = Eigen::SparseMatrix<double>; ///< both triangles
using Unknown = Eigen::VectorXd;

class Factor {
public:
    virtual ~Factor() = default;
    virtual std::string_view name() const = 0;
    /// True where make_factor would give one of this kind.
    virtual bool suits(const Stiffness& matrix, bool symmetric) const = 0;
    /// False where it is singular to working precision.
    virtual bool factorise(const Stiffness& matrix) = 0;
    virtual Unknown solve(const Unknown& right) const = 0;
    /// Negative eigenvalues of a symmetric matrix; -1: not known.
    virtual long negative() const = 0;
    /// Numbers that the factor keeps, on all ranks together.
    virtual double entries() const = 0;
};

/// The factor for such a matrix: its pattern, and whether it is symmetric. `ranks`: that all have the same matrices and
/// make the same calls, and among which large factors are distributed; null: this rank has them by itself.
std::unique_ptr<Factor> make_factor(const Stiffness& matrix, bool symmetric, const Communicator* ranks = nullptr);

/// Holds unknowns at 0: rows and columns of the unit matrix, times the size of the diagonal.
void hold(Stiffness& matrix, const std::vector<int>& pins);

/// Scales S of S K S with a diagonal of 1, in which forces and couples, thick and thin rods compare.
inline Unknown scales_of(const Stiffness& matrix) {
    Unknown scale = matrix.diagonal().cwiseAbs();
    for (Eigen::Index i = 0; i < scale.size(); ++i) scale[i] = scale[i] > 0 ? 1 / std::sqrt(scale[i]) : 1;
    return scale;
}

/// Largest |i - j| of entries.
long half_bandwidth(const Stiffness& matrix);

} // namespace skein
