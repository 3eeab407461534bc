// Modes of a scene's bodies about their equilibrium: the lowest of all pieces, as a table and as moving shapes.
#pragma once

#include "equilibrium/modes.hpp"
#include "studies/equilibrium_study.hpp"

#include <string>
#include <vector>

namespace skein {

/// A mode of a piece.
struct PieceMode {
    std::size_t piece; ///< place in the scene's pieces; of another rank's none
    std::string name;  ///< rod or assembly that moves
    Mode mode;
};

struct ModesReport {
    std::vector<PieceMode> modes; ///< of all ranks, lowest first, neutral ones first of all; shapes of this rank's
    std::int64_t neutral = 0;     ///< motions that change no load
    std::string neutral_names;    ///< of the first few
    double asymmetry = 0;         ///< largest, of stiffnesses whose symmetric part is taken
    bool damped = false;     ///< modes of some piece have damping, gyroscopic couples, or loads without a potential
    bool gyroscopic = false; ///< rods of some piece spin about their axes
    bool slowed = false;     ///< some do, but not steadily, so that the spin is left out
    std::string method;
    double seconds = 0;
};

/// The `count` lowest beside neutral ones. `undamped`: what damps or spins is left out. Collective. Throws
/// NumericalError where a piece has none.
ModesReport find_modes(StaticScene& scene, int count, bool undamped = false);
std::string to_text(const ModesReport& report);
/// Comma-separated, with units.
std::string to_csv(const ModesReport& report);
/// State of a piece at a phase of a mode's swing, rad, as if it did not decay, with `largest` m as the size of its
/// largest displacement.
StaticState moved_along(const StaticPiece& piece, const Mode& mode, double phase, double largest);

} // namespace skein
