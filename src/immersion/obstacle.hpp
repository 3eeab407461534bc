// Bodies in a fluid whose motion is given.
#pragma once

#include "fluid/fluid_grid.hpp"
#include "skein/core/fields.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace skein {

enum class ObstacleKind { sphere, cylinder };
inline constexpr std::string_view obstacle_names[] = {"sphere", "cylinder"};

/// [[obstacle]]: rests, moves or swings, and is not moved by the fluid.
struct Obstacle {
    std::string name = "obstacle";
    ObstacleKind kind = ObstacleKind::sphere;
    Vec3d centre{0, 0, 0};    ///< m, at the start
    double radius = 0;        ///< m
    double second_radius = 0; ///< m, of a cylinder of elliptic section, along y; 0: as the first
    Vec3d velocity{0, 0, 0};  ///< m/s
    Vec3d amplitude{0, 0, 0}; ///< m, of a sine
    double frequency = 0;     ///< Hz
    double retraction = 0.4;  ///< of markers into the body, over the spacing of the grid
    std::string source;       ///< file:line of the table, for messages

    void fields(FieldVisitor& f);

    /// Of its centre.
    Vec3d place_at(double time) const;
    Vec3d velocity_at(double time) const;
    bool moves() const;
    /// Within the box; of a cylinder, its length along z is that of the box.
    double volume(const FluidGrid& grid) const;
    /// About its centre.
    std::vector<Vec3d> markers(const FluidGrid& grid) const;
};

} // namespace skein
