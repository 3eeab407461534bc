// A rod of a reference file: constants as the file has them, state at the start, and its step with the published conventions made
// of the library's passes.
#pragma once

#include "constraints.hpp"
#include "entry.hpp"
#include "loads.hpp"

#include "rod/rod_tiles.hpp"

namespace skein::replay {

struct System {
    RodGroup group;
    std::vector<Slot<1>> start; ///< [n + 1]; a ring's last slot is a copy of the first node
};

/// `entry` of `systems`. Throws NotBuilt for what is not a rod.
System read_system(const Entry& entry, int number);

struct Stepping {
    Scheme scheme;
    double dt; ///< s
};

/// Step of one rod and what its results are read from.
struct Program {
    TileProgram<1> passes;
    std::vector<std::shared_ptr<const Constraint>> constraints;
    const External* loads; ///< owned by `passes`
};

/// Entries of the file's lists that act on rod `number` of `systems`.
Program make_program(const Entry& file, const System& system, int number, const Stepping& stepping);

} // namespace skein::replay
