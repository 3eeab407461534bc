// Surfaces of bodies in coordinates of the body: the side of a place, and where grid lines cross.
#pragma once

#include "skein/core/vec3.hpp"

#include <limits>

namespace skein {

class Surface {
public:
    static constexpr double unbounded = std::numeric_limits<double>::infinity();

    virtual ~Surface() = default;
    /// Signed distance of a place, m, above 0 in the fluid, or a number nearer to 0 with this sign. It changes by at
    /// most the distance of two places.
    virtual double distance(const Vec3d& place) const = 0;
    /// Share of the way from a place in the fluid to a place within the body at which the surface lies.
    virtual double crossing(const Vec3d& outside, const Vec3d& inside) const;
    /// Half extents of a box about the origin that holds the body, m.
    virtual Vec3d extent() const = 0;
};

class SphereSurface final : public Surface {
public:
    explicit SphereSurface(double radius) : radius_(radius) {}
    double distance(const Vec3d& place) const override { return norm(place) - radius_; }
    double crossing(const Vec3d& outside, const Vec3d& inside) const override;
    Vec3d extent() const override { return {radius_, radius_, radius_}; }

private:
    double radius_;
};

/// Elliptic cylinder along z without ends.
class TubeSurface final : public Surface {
public:
    /// Half axes along x and y, m.
    TubeSurface(double a, double b);
    double distance(const Vec3d& place) const override;
    double crossing(const Vec3d& outside, const Vec3d& inside) const override;
    Vec3d extent() const override { return {a_, b_, unbounded}; }

private:
    double a_, b_, least_;
};

} // namespace skein
