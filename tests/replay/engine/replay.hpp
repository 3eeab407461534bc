// Runs a reference file and holds every recorded step against it.
#pragma once

#include "entry.hpp"

namespace skein::replay {

/// One comparison of a field at a recorded step, the worst over all systems.
struct Deviation {
    long step;
    std::string field;
    double value; ///< largest |difference| over the field's scale
    double tolerance;
    bool agrees() const { return value <= tolerance; }
};

/// Replays the systems of a file. Throws InputError, NotBuilt.
std::vector<Deviation> replay_systems(const Entry& file);

/// Twist, writhe and link of the framed curves of a file (curves.cpp); the field is the path of the value in the file,
/// step 0.
std::vector<Deviation> replay_curves(const Entry& file);

} // namespace skein::replay
