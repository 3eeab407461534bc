// Bodies in a fluid with a prescribed motion.
#pragma once

#include "fluid/fluid_grid.hpp"
#include "immersion/surface.hpp"
#include "rod/body_shape.hpp"
#include "rod/solids.hpp"
#include "skein/core/fields.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

enum class ObstacleKind { sphere, cylinder, capsule, box, ellipsoid, mesh };
inline constexpr std::string_view obstacle_names[] = {"sphere", "cylinder", "capsule", "box", "ellipsoid", "mesh"};

/// How a body makes the fluid at its surface move with it.
enum class SurfaceKind {
    markers, ///< DirectForcing
    sharp    ///< SharpForcing
};
inline constexpr std::string_view surface_names[] = {"markers", "sharp"};

/// [[obstacle]]: body that rests, moves, turns or swings, unaffected by the fluid.
struct Obstacle {
    std::string name = "obstacle";
    ObstacleKind kind = ObstacleKind::sphere;
    Vec3d centre{0, 0, 0};           ///< m, at the start
    double radius = 0;               ///< m, of the edges of a box
    double second_radius = 0;        ///< m, half axis along y of an elliptic cylinder; 0: `radius`
    double length = 0;               ///< m, between the centres of a capsule's round ends
    Vec3d sides{0, 0, 0};            ///< m, of a box
    Vec3d half_axes{0, 0, 0};        ///< m, of an ellipsoid
    std::string file;                ///< of a mesh, relative to the scene
    double unit = 1;                 ///< m, length of 1 in the file
    Vec3d axis{0, 0, 1};             ///< direction of its z axis at the start
    std::optional<Vec3d> normal;     ///< direction of its x axis
    Vec3d velocity{0, 0, 0};         ///< m/s
    Vec3d angular_velocity{0, 0, 0}; ///< rad/s, about the centre, lab
    Vec3d amplitude{0, 0, 0};        ///< m, amplitude of a sine
    double frequency = 0;            ///< Hz
    SurfaceKind surface = SurfaceKind::markers;
    double retraction = 0.4;                  ///< depth of markers in the body over the spacing of the grid
    std::string source;                       ///< file:line of the table, for messages
    std::shared_ptr<const TriangleMesh> mesh; ///< that of the file

    void fields(FieldVisitor& f);

    /// Place of the centre at a time, m.
    Vec3d place_at(double time) const;
    Vec3d velocity_at(double time) const;
    /// Rows: axes of the shape at a time.
    Mat3d axes_at(double time) const;
    bool moves() const;
    /// Largest velocity of the surface by the turning alone, m/s.
    double turning_speed() const;
    bool turns() const { return norm(angular_velocity) > 0; }
    /// Volume, m^3, its centre from that of the obstacle and its inertia over the mass, along the axes of the shape. A
    /// cylinder is as long as the box along z.
    Solid solid(const FluidGrid& grid) const;
    /// Shorter half axis, m; of a mesh half of the thinnest side of its box.
    double least_axis() const;
    /// Sides of the box along the axes of the shape that holds it, m. That of a cylinder is unbounded along z.
    Vec3d sides_of_box() const;
    bool is_sharp() const { return surface == SurfaceKind::sharp; }
    /// Surface about the centre, along the axes of the shape.
    std::unique_ptr<Surface> shape() const;
    /// Places of markers from the centre at the start, m. Ellipsoids and meshes have none.
    std::vector<Vec3d> markers(const FluidGrid& grid) const;
    bool takes_markers() const { return kind != ObstacleKind::ellipsoid && kind != ObstacleKind::mesh; }

private:
    double second() const { return second_radius > 0 ? second_radius : radius; }
    /// Part that a capsule or a box is.
    BodyShape::Part part() const;
};

} // namespace skein
