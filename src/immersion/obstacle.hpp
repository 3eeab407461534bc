// Bodies in a fluid with a prescribed motion.
#pragma once

#include "fluid/fluid_grid.hpp"
#include "immersion/surface.hpp"
#include "skein/core/fields.hpp"

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

enum class ObstacleKind { sphere, cylinder };
inline constexpr std::string_view obstacle_names[] = {"sphere", "cylinder"};

/// How a body makes the fluid at its surface move with it.
enum class SurfaceKind {
    markers, ///< DirectForcing
    sharp    ///< SharpForcing
};
inline constexpr std::string_view surface_names[] = {"markers", "sharp"};

/// [[obstacle]]: body that rests, moves or swings, unaffected by the fluid.
struct Obstacle {
    std::string name = "obstacle";
    ObstacleKind kind = ObstacleKind::sphere;
    Vec3d centre{0, 0, 0};    ///< m, at the start
    double radius = 0;        ///< m
    double second_radius = 0; ///< m, half axis along y of an elliptic cylinder; 0: `radius`
    Vec3d velocity{0, 0, 0};  ///< m/s
    Vec3d amplitude{0, 0, 0}; ///< m, amplitude of a sine
    double frequency = 0;     ///< Hz
    SurfaceKind surface = SurfaceKind::markers;
    double retraction = 0.4; ///< depth of markers in the body over the spacing of the grid
    std::string source;      ///< file:line of the table, for messages

    void fields(FieldVisitor& f);

    /// Place of the centre at a time, m.
    Vec3d place_at(double time) const;
    Vec3d velocity_at(double time) const;
    bool moves() const;
    /// Volume in the box, m^3. A cylinder is as long as the box along z.
    double volume(const FluidGrid& grid) const;
    /// Shorter half axis, m.
    double least_axis() const;
    bool is_sharp() const { return surface == SurfaceKind::sharp; }
    /// Surface about the centre.
    std::unique_ptr<Surface> shape() const;
    /// Places of markers from the centre, m.
    std::vector<Vec3d> markers(const FluidGrid& grid) const;
};

} // namespace skein
