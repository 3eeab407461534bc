// Cubes of space with the elements of a rod near them, so that few elements are searched for the one nearest to a
// place.
#pragma once

#include "skein/core/vec3.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace skein {

class ElementCubes {
public:
    /// Elements by the middle of each, m, and the radius of a ball about it that holds the element, m. `near`, m: from
    /// a place, elements within this distance are found.
    /// There are no cubes where places are not finite or much too far apart.
    void fill(std::span<const Vec3d> middle, std::span<const double> cover, double near);
    /// Elements of the cube of a place, in their order; empty where no cube is.
    std::span<const std::uint32_t> at(const Vec3d& place) const;

private:
    double size_ = 0;      ///< m
    Vec3d lower_{0, 0, 0}; ///< corner of the first cube, m
    std::array<int, 3> count_{};
    std::vector<std::uint32_t> first_, element_; ///< elements of cube c: from first_[c] to first_[c + 1]
};

} // namespace skein
