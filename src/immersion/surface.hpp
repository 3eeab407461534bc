// Surfaces of bodies as signed distances, in coordinates of the body.
#pragma once

#include "skein/core/vec3.hpp"

#include <limits>

namespace skein {

class Surface {
public:
    static constexpr double unbounded = std::numeric_limits<double>::infinity();

    virtual ~Surface() = default;
    /// Signed distance of a place, m, above 0 in the fluid. Far from the surface only its sign needs to be right.
    virtual double distance(const Vec3d& place) const = 0;
    /// Half extents of a box about the origin that holds the body, in whatever way it is turned if it turns, m.
    virtual Vec3d extent() const = 0;
};

class SphereSurface final : public Surface {
public:
    explicit SphereSurface(double radius) : radius_(radius) {}
    double distance(const Vec3d& place) const override { return norm(place) - radius_; }
    Vec3d extent() const override { return {radius_, radius_, radius_}; }

private:
    double radius_;
};

/// Elliptic cylinder along z without ends.
class TubeSurface final : public Surface {
public:
    /// Half axes along x and y, m.
    TubeSurface(double a, double b) : a_(a), b_(b) {}
    double distance(const Vec3d& place) const override;
    Vec3d extent() const override { return {a_, b_, unbounded}; }

private:
    double a_, b_;
};

} // namespace skein
