// Small motions about an equilibrium without damping: K phi = w^2 M phi.                       theory.md (101)
// Contacts with friction stick.
//   M     masses of nodes and inertias of elements, as a run has them
//   few   unknowns: all eigenvalues, densely; many: the lowest by shifted and inverted Lanczos (Spectra)
#pragma once

#include "equilibrium/static_system.hpp"

#include <string>
#include <vector>

namespace skein {

struct Mode {
    double eigenvalue = 0; ///< w^2, 1/s^2; negative where the energy falls, and the motion grows
    double residual = 0;   ///< |K phi - w^2 M phi| over |K| |phi|, unknown by unknown in sum
    bool neutral = false;  ///< a motion that changes no load
    Unknown shape;         ///< with phi.M phi = 1

    /// Frequency, Hz; of growth, 1/s over 2 pi, where the eigenvalue is negative.
    double frequency() const;
};

struct ModesResult {
    std::vector<Mode> modes; ///< lowest first
    NeutralMotions neutral;
    double asymmetry = 0; ///< of the stiffness where friction sticks, whose symmetric part is taken
    std::string method;
    std::string reason; ///< why there are none; empty: there are
};

/// The lowest `count` modes beside neutral ones, which come first. The loads must have a potential.
ModesResult find_modes(StaticSystem& system, const StaticState& state, int count);

} // namespace skein
