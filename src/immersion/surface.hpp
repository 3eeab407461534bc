// Surfaces of bodies as signed distances, in coordinates of the body.
#pragma once

#include "immersion/triangle_mesh.hpp"
#include "skein/core/vec3.hpp"

#include <limits>
#include <memory>

namespace skein {

class Surface {
public:
    static constexpr double unbounded = std::numeric_limits<double>::infinity();

    virtual ~Surface() = default;
    /// Signed distance of a place, m, above 0 in the fluid. Far from the surface only its sign needs to be right.
    virtual double distance(const Vec3d& place) const = 0;
    /// True where no distance changes by more than the way between two places.
    virtual bool steady() const { return false; }
    /// Half extents of a box about the origin that holds the body, in whatever way it is turned if it turns, m.
    virtual Vec3d extent() const = 0;
};

class SphereSurface final : public Surface {
public:
    explicit SphereSurface(double radius) : radius_(radius) {}
    double distance(const Vec3d& place) const override { return norm(place) - radius_; }
    bool steady() const override { return true; }
    Vec3d extent() const override { return {radius_, radius_, radius_}; }

private:
    double radius_;
};

/// Elliptic cylinder along z without ends.
class TubeSurface final : public Surface {
public:
    /// Half axes along x and y, m. `turned`: they may have other directions in the box.
    TubeSurface(double a, double b, bool turned = false) : a_(a), b_(b), turned_(turned) {}
    double distance(const Vec3d& place) const override;
    Vec3d extent() const override;

private:
    double a_, b_;
    bool turned_;
};

class EllipsoidSurface final : public Surface {
public:
    /// Half axes, m.
    explicit EllipsoidSurface(const Vec3d& half_axes) : half_(half_axes) {}
    /// Along the normal from the nearest point, (151).
    double distance(const Vec3d& place) const override;
    bool steady() const override { return true; }
    Vec3d extent() const override;

private:
    Vec3d half_;
};

class MeshSurface final : public Surface {
public:
    explicit MeshSurface(std::shared_ptr<const TriangleMesh> mesh) : mesh_(std::move(mesh)), reach_(mesh_->reach()) {}
    double distance(const Vec3d& place) const override { return mesh_->distance(place); }
    bool steady() const override { return true; }
    Vec3d extent() const override { return {reach_, reach_, reach_}; }

private:
    std::shared_ptr<const TriangleMesh> mesh_;
    double reach_;
};

} // namespace skein
