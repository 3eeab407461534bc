// Weights of the Laplacian at a node whose face or grid lines a surface cuts. theory.md (136)-(138)
#pragma once

#include "skein/core/vec3.hpp"

#include <array>

namespace skein {

/// Change of the Laplacian, times the square of the spacing, for velocities relative to the body's:
/// sum of ahead (neighbour's velocity) - excess (node's velocity). The neighbour of a direction is on the side of the
/// fluid.
struct CutWeights {
    double open = 0; ///< mean of the distance from the surface over the open part of the face; about 0: it is closed
    double closed_share = 0; ///< of the face, within the body
    double excess = 0;
    std::array<double, 3> ahead{};

    static constexpr double least_open = 1e-6;
    bool closed() const { return open < least_open; }
};

/// Treatment of the lines of a direction.
enum class CutLines {
    quadratic, ///< profiles of second degree are exact
    linear,    ///< profiles of first degree are exact, and the neighbour ahead keeps its weight
    none       ///< the lines stay as they are
};

/// For a node of a component at a signed distance, in cells, from a plane with this normal towards the fluid.
CutWeights cut_weights(double distance, const Vec3d& normal, int component, const std::array<CutLines, 3>& lines);

} // namespace skein
