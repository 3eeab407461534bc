// Twist, writhe and link of framed curves.                                         theory.md (42)-(44)
// A curve is a polygon: n + 1 nodes and n segments where it is open, n nodes and n segments where it is closed (the
// last segment returns to node 0, which is not repeated). Its frame is one vector per segment, d1, which need not be
// quite normal to it. Angles are counted in turns; right-handed twist and right-handed crossings are positive. Sources:
// Klenin & Langowski 2000 (Biopolymers 54, 307), methods 1a and 2a; end segments as in Charles et al. 2019 (PRL 123,
// 208003, section S2) and PyElastica. Where these take arcsin and arccos we take the same angles by atan2. Near
// coplanar segments arcsin loses half of the digits: with end segments published writhe and link carry noise of some
// 1e-9.
#pragma once

#include "skein/core/vec3.hpp"

#include <span>
#include <vector>

namespace skein {

enum class Curve { open, closed };

/// Which way the straight segments point that are added at both ends of an open curve before its writhe or link is
/// taken.
enum class EndSegments {
    none,
    next_tangent, ///< along the first and last segment
    end_to_end,   ///< along the line through both ends
    net_tangent   ///< along the line from the mean of the first half's nodes to that of the second half, weighted as
                  ///< published
};

/// Nodes with one more at either end, `length` [m] away. `node`: lab, m, [n + 1]; result [n + 3], or [n + 1] for
/// `none`.
std::vector<Vec3d> with_end_segments(std::span<const Vec3d> node, double length, EndSegments kind);

/// Turns of d1 about the tangent from each segment to the next, in (-1/2, 1/2]: the angle left after d1 has been
/// carried over by the smallest rotation between the tangents. `node`: lab, m; `d1`: lab, [n]. Result [n - 1], or [n]
/// where closed: entry i belongs to the vertex after segment i. Segments that reverse on themselves have no such
/// rotation. Cost: 60 flop per vertex.
std::vector<double> local_twist(std::span<const Vec3d> node, std::span<const Vec3d> d1, Curve curve);

/// Sum of local_twist.
double twist(std::span<const Vec3d> node, std::span<const Vec3d> d1, Curve curve);

/// Gauss's double integral of a polygon with itself, exact for straight segments; of an open curve as it stands,
/// without end segments. `node`: lab, m. Cost: 90 flop and 2 atan2 per pair of segments, n^2/2 pairs.
double writhe(std::span<const Vec3d> node, Curve curve);

/// Gauss's double integral of two polygons that do not meet: their linking number where both are closed.
double linking(std::span<const Vec3d> a, Curve curve_a, std::span<const Vec3d> b, Curve curve_b);

/// The published link of an open rod: Gauss's integral of the centre line with an auxiliary line at distance `radius`
/// [m, one per segment] along d1, both with the centre line's end segments. Node 0 takes d1 and radius of segment 0,
/// node i those of segment i - 1. Tends to twist + writhe for fine and thin rods.
double auxiliary_link(std::span<const Vec3d> node, std::span<const Vec3d> d1, std::span<const double> radius,
                      double length, EndSegments kind);

} // namespace skein
