// Rods from points along them (docs/traced_files.md): a smooth curve through the points, cut into elements of equal arc
// length, and a bound on its distance from the line through the points.
#pragma once

#include "skein/core/vec3.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace skein {

/// Curve through points p_i. Its parameter is the length along the chords, h_i = |p_i+1 - p_i|. Each piece is the cubic
///
///   c(u) = p_i + u m_i + u^2/h_i (3 d_i - 2 m_i - m_i+1) + u^3/h_i^2 (m_i + m_i+1 - 2 d_i),   d_i = (p_i+1 - p_i)/h_i,
///
/// with tangents m_i that make the second derivative continuous,
///
///   h_i m_i-1 + 2 (h_i-1 + h_i) m_i + h_i-1 m_i+1 = 3 (h_i d_i-1 + h_i-1 d_i),
///
/// and with the tangents of the cubics through four points at both ends. Tangents are not longer than 2, so that no
/// piece is farther than h_i/2 from its chord. Smooth curves have tangents near 1, which the limit leaves as they
/// are.
class PointCurve {
public:
    /// Takes two points or more, of which no neighbours are the same. Memory is used again.
    void pass_through(std::span<const Vec3d> points);

    /// Arc length, m.
    double length() const { return length_; }

    /// Place on the curve: a piece and the share of its chord's length.
    struct Place {
        std::size_t piece;
        double share; ///< 0 to 1
    };
    /// Places that cut the curve into equal arc lengths, both ends included.
    void cut(std::size_t elements, std::vector<Place>& places) const;

    Vec3d at(const Place& place) const;

    /// Bound on the distance between the line through `nodes`, which lie at `places`, and the line through the points,
    /// m. It is the largest distance between partners as both lines are walked from start to end, so that neither line
    /// is farther from the other one anywhere.
    double deviation(std::span<const Place> places, std::span<const Vec3d> nodes) const;

private:
    void find_tangents();
    void limit_tangents();
    Vec3d end_tangent(std::size_t end, int way) const; ///< `way`: 1 at the first point, -1 at the last
    double piece_length(std::size_t i) const;
    double share_of_length(std::size_t piece, double s) const; ///< share of a piece that ends at arc length s

    std::span<const Vec3d> points_;
    std::vector<double> chord_;  ///< h_i, m
    std::vector<Vec3d> way_;     ///< d_i
    std::vector<Vec3d> tangent_; ///< m_i
    std::vector<double> arc_;    ///< arc length of each piece, m
    std::vector<double> upper_;  ///< of the elimination
    double length_ = 0;
};

/// Value at a place that is linear between points.
double value_at(const PointCurve::Place& place, std::span<const double> of_points);
Vec3d value_at(const PointCurve::Place& place, std::span<const Vec3d> of_points);

} // namespace skein
