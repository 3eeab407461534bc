// Twist, writhe and link of framed curves.                                         theory.md (42)-(44)
// A curve is a polygon of n segments: n + 1 nodes if it is open, n nodes if it is closed. The last segment of a closed
// curve returns to node 0, which is not repeated. Its frame is one vector per segment, d1, which need not be quite
// normal to it. Angles are counted in turns; right-handed twist and right-handed crossings are positive. Sources:
// Klenin & Langowski 2000 (Biopolymers 54, 307), methods 1a and 2a; end segments of Charles et al. 2019 (PRL 123,
// 208003, section S2) and PyElastica. This code finds their arcsin and arccos by atan2. Near coplanar segments arcsin
// loses half of the digits, and published writhe and link with end segments have noise of about 1e-9.
#pragma once

#include "skein/core/vec3.hpp"

#include <span>
#include <vector>

namespace skein {

enum class Curve { open, closed };

/// Direction of straight segments that extend both ends of an open curve for its writhe or link.
enum class EndSegments {
    none,
    next_tangent, ///< along the first and last segment
    end_to_end,   ///< along the line through both ends
    net_tangent   ///< along the line between the means of both halves' nodes, weighted as published
};

/// Adds a node at each end, at a distance of `length` [m]. `node`: lab, m, [n + 1]; result [n + 3], or [n + 1] for
/// `none`.
std::vector<Vec3d> with_end_segments(std::span<const Vec3d> node, double length, EndSegments kind);

/// Turns of d1 about the tangent from each segment to the next, in (-1/2, 1/2]. It is the angle that remains after the
/// smallest rotation between the tangents. `node`: lab, m; `d1`: lab, [n]. Result [n - 1], or [n] for a closed curve;
/// entry i belongs to the vertex after segment i. Reversing segments have no such rotation. Cost: 60 flop per vertex.
std::vector<double> local_twist(std::span<const Vec3d> node, std::span<const Vec3d> d1, Curve curve);

/// Sum of local_twist.
double twist(std::span<const Vec3d> node, std::span<const Vec3d> d1, Curve curve);

/// Gauss's double integral of a polygon with itself, exact for straight segments, without end segments. `node`: lab, m.
/// Cost: 90 flop and 2 atan2 per pair of segments, n^2/2 pairs.
double writhe(std::span<const Vec3d> node, Curve curve);

/// Gauss's double integral of two disjoint polygons: the linking number if both are closed.
double linking(std::span<const Vec3d> a, Curve curve_a, std::span<const Vec3d> b, Curve curve_b);

/// Published link of an open rod: Gauss's integral of the centre line with an auxiliary line at distance `radius` [m,
/// one per segment] along d1. Both have the centre line's end segments. Node 0 has d1 and radius of segment 0, node i
/// those of segment i - 1. It tends to twist + writhe for fine and thin rods.
double auxiliary_link(std::span<const Vec3d> node, std::span<const Vec3d> d1, std::span<const double> radius,
                      double length, EndSegments kind);

} // namespace skein
