// Places of nodes, elements and vertices along a rod, and interpolation between them.
#pragma once

#include "skein/core/vec3.hpp"
#include "skein/rod/rod_spec.hpp"

#include <vector>

namespace skein {

/// Places of nodes 0 to n from the start, over the length.
std::vector<double> nodes_of(const Shape& shape);
/// Places of the middles of elements, over the length.
std::vector<double> middles_of(const Shape& shape);
/// Places of inner vertices, over the length; in a ring the last one is where it closes.
std::vector<double> vertices_of(const Shape& shape);

/// Linear interpolation to places `to`, between values at rising places, round a ring. Beyond the first and last place
/// the nearest piece is extended.
std::vector<double> between(const std::vector<double>& at, const std::vector<double>& value,
                            const std::vector<double>& to, bool ring);
std::vector<Vec3d> between(const std::vector<double>& at, const std::vector<Vec3d>& value,
                           const std::vector<double>& to, bool ring);

} // namespace skein
