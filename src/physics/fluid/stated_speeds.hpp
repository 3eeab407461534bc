// Speeds of rods in a fluid that follow from what a scene states, before anything has moved.                theory.md
// (93), (94)
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/rod/rod_group.hpp"

#include <cmath>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Sum of the sizes of components: how a speed counts for a grid.
inline double sum_of(const Vec3d& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

struct StatedSpeed {
    double value = 0;     ///< m/s, a sum of components where the direction is known
    std::string by;       ///< in words
    bool at_once = false; ///< at t = 0: a fact of the start, not an estimate of what follows
};

/// All that are above 0. Ranks find the same, whatever rods of a file they know. `loads`: with formulas read.
std::vector<StatedSpeed> stated_speeds(const SceneSpec& scene, std::span<const RodGroup> groups,
                                       std::span<const Load> loads);

/// Muscles and rest curvatures that differ from the shape at t = 0, in words.
std::vector<std::string> abrupt_starts(const SceneSpec& scene, std::span<const RodGroup> groups,
                                       std::span<const Load> loads);

} // namespace skein
