// Rigid motion of fluid by least squares over velocity nodes.
#pragma once

#include "skein/core/vec3.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace skein {

/// Velocity at an origin and spin about it.
struct RigidMotion {
    Vec3d velocity{0, 0, 0}, spin{0, 0, 0}; ///< m/s, rad/s
};

/// Normal equations: the lower triangle of their matrix row by row, then their right side. Those of two sets of nodes
/// add up to those of both.
class RigidFit {
public:
    static constexpr std::size_t unknowns = 6, numbers = unknowns * (unknowns + 1) / 2 + unknowns;

    RigidFit() = default;
    explicit RigidFit(std::span<const double, numbers> sums) { std::copy(sums.begin(), sums.end(), sum_.begin()); }

    /// A node has the velocity u along a direction of length 1, at an arm from the origin.
    void add(const Vec3d& arm, const Vec3d& direction, double u) {
        const Vec3d turning = cross(arm, direction);
        const std::array<double, unknowns> of{direction.x, direction.y, direction.z, turning.x, turning.y, turning.z};
        std::size_t at = 0;
        for (std::size_t i = 0; i < unknowns; ++i)
            for (std::size_t j = 0; j <= i; ++j) sum_[at++] += of[i] * of[j];
        for (const double x : of) sum_[at++] += x * u;
    }
    std::span<const double, numbers> sums() const { return sum_; }

    /// By Cholesky's factors; at rest where the nodes leave a motion open.
    RigidMotion solve() const {
        std::array<std::array<double, unknowns>, unknowns> factor{};
        std::array<double, unknowns> x{};
        for (std::size_t i = 0; i < unknowns; ++i) {
            x[i] = sum_[numbers - unknowns + i];
            for (std::size_t j = 0; j <= i; ++j) {
                const double own = sum_[i * (i + 1) / 2 + j];
                double left = own;
                for (std::size_t k = 0; k < j; ++k) left -= factor[i][k] * factor[j][k];
                if (i == j && !(left > rounding * own)) return {};
                factor[i][j] = i == j ? std::sqrt(left) : left / factor[j][j];
            }
            for (std::size_t j = 0; j < i; ++j) x[i] -= factor[i][j] * x[j];
            x[i] /= factor[i][i];
        }
        for (std::size_t i = unknowns; i-- > 0;) {
            for (std::size_t j = i + 1; j < unknowns; ++j) x[i] -= factor[j][i] * x[j];
            x[i] /= factor[i][i];
        }
        return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
    }

private:
    static constexpr double rounding = 1e-10;
    std::array<double, numbers> sum_{};
};

} // namespace skein
