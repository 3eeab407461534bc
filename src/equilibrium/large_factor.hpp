// Factors of large stiffnesses by PETSc and MUMPS, which pivot and count signs: a library of its own, opened where a
// matrix is large, and there alone.
#pragma once

#include "equilibrium/factor.hpp"

#include <memory>

namespace skein {

/// Unknowns from which the library is opened, where Skein was built with it.
inline constexpr Eigen::Index large_unknowns = 20000;

/// Null where Skein was built without PETSc, or the library cannot be loaded.
/// `ranks`: as make_factor() has it.
std::unique_ptr<Factor> make_large_factor(bool symmetric, const Communicator* ranks = nullptr);

} // namespace skein
