// Where what a scene lists by node, element or vertex stands along a rod, and its values at other places.
#pragma once

#include "skein/core/vec3.hpp"
#include "skein/rod/rod_spec.hpp"

#include <vector>

namespace skein {

/// Of nodes 0 to n from the start, over the length.
std::vector<double> nodes_of(const Shape& shape);
/// Of the middles of elements.
std::vector<double> middles_of(const Shape& shape);
/// Of inner vertices; of a ring also where it closes, as the last.
std::vector<double> vertices_of(const Shape& shape);

/// Values at `to` of what is linear between values at rising places, of a ring round it; beyond them as in the last
/// piece.
std::vector<double> between(const std::vector<double>& at, const std::vector<double>& value,
                            const std::vector<double>& to, bool ring);
std::vector<Vec3d> between(const std::vector<double>& at, const std::vector<Vec3d>& value,
                           const std::vector<double>& to, bool ring);

} // namespace skein
