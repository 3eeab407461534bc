// Keys of rods that are packed at random: number, region and directions.
#pragma once

#include "skein/core/fields.hpp"

#include <string_view>
#include <vector>

namespace skein {

enum class PackingRegion { box, cylinder, slab };
inline constexpr std::string_view packing_region_names[] = {"box", "cylinder", "slab"};

enum class ElevationLaw { isotropic, uniform };
inline constexpr std::string_view elevation_law_names[] = {"isotropic", "uniform"};

struct Packing {
    long count = 0;
    long seed = 1;
    PackingRegion region = PackingRegion::box;
    Vec3d lower{0, 0, 0}, upper{0, 0, 0};   ///< m; corners of a box or slab; upper.z of a slab has no effect
    Vec3d point{0, 0, 0};                   ///< m; cylinder: centre of its base, its axis along z
    double radius = 0, height = 0;          ///< m; cylinder
    std::vector<double> elevation{-90, 90}; ///< deg, least and largest angle of d3 above the horizontal plane
    std::vector<double> azimuth{0, 360};    ///< deg, angle of d3 around z, from x
    ElevationLaw elevation_law = ElevationLaw::isotropic;
    double gap = 0;         ///< m, least gap between surfaces; 0: 0.05 radii
    long attempts = 100000; ///< attempts to place a rod before an error; a slab grows after a hundredth of them

    void fields(FieldVisitor& f);
};

} // namespace skein
