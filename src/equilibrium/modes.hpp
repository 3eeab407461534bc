// Small motions about an equilibrium. Without damping K phi = w^2 M phi, theory.md (101); else, and where loads have no
// potential, (lambda^2 M + lambda C + K) phi = 0, theory.md (107)-(109).
// Contacts with friction stick.
//   M     masses of nodes and inertias of elements, as a run has them
//   few   unknowns: all eigenvalues, densely; many: the lowest by shifted and inverted Lanczos (Spectra)
#pragma once

#include "equilibrium/static_system.hpp"

#include <complex>
#include <string>
#include <vector>

namespace skein {

struct Mode {
    double eigenvalue =
        0;               ///< w^2, 1/s^2; negative where the energy falls, and the motion grows; with damping |lambda|^2
    double residual = 0; ///< |(lambda^2 M + lambda C + K) phi| over the sum of its terms, unknown by unknown in sum
    bool neutral = false;          ///< a motion that changes no load
    Unknown shape;                 ///< with phi.M phi = 1
    std::complex<double> exponent; ///< lambda, 1/s: the motion is exp(lambda t)
    Unknown quadrature;            ///< imaginary part of phi; empty where all moves in phase

    /// Frequency, Hz; without damping of growth, 1/s over 2 pi, where the eigenvalue is negative.
    double frequency() const;
    double decay() const { return 0.0 - exponent.real(); } ///< rate, 1/s; negative where the motion grows
    /// Decay over the size of lambda: 1 where the motion does not swing.
    double damping_ratio() const;
    bool grows() const; ///< by more than round-off
};

struct ModesResult {
    std::vector<Mode> modes; ///< lowest first
    NeutralMotions neutral;
    bool damped = false;     ///< C or the lack of a potential counts
    bool gyroscopic = false; ///< rods spin about their axes
    bool slowed = false;     ///< they do, but something resists, so that the spin is left out
    double asymmetry = 0;    ///< of the stiffness where friction sticks, whose symmetric part is taken
    std::string method;
    std::string reason; ///< why there are none; empty: there are
};

/// The lowest `count` modes beside neutral ones, which come first. `undamped`: what damps or spins is left out.
ModesResult find_modes(StaticSystem& system, const StaticState& state, int count, bool undamped = false);

} // namespace skein
