// What published contacts of rods share: elements as straight segments, the nearest points of two of them, boxes, and
// how the force on an element is divided between its nodes.
#pragma once

#include "rod.hpp"

namespace skein::replay {

/// Contacts act from this gap on (negative: apart), m.
inline constexpr double least_overlap = -1e-5;

/// An element at the present positions.
struct Segment {
    Vec3d start, edge; ///< m, lab
    double length;     ///< |edge| + 1e-14 m, as published
    double radius;     ///< of the present length at constant volume, m
};
/// [n]
std::vector<Segment> segments_of(const Rod& rod);

/// From the nearest point of segment a to that of segment b, and the latter.
struct Nearest {
    Vec3d gap, point_of_b;
};
/// Both segments have lengths.
Nearest nearest(const Vec3d& start_a, const Vec3d& edge_a, const Vec3d& start_b, const Vec3d& edge_b);

/// Along the axes.
struct Box {
    Vec3d lower, upper;
    bool apart_from(const Box& b) const;
};
/// Of the rod's nodes, wider by `reach` on every side.
Box box_of(const Rod& rod, double reach);
double largest_radius(const std::vector<Segment>& segments);
double largest_length(const std::vector<Segment>& segments);

/// How much of the force on an element each of its nodes gets. Published contacts give it to both in full; in the first
/// and last element a third of it goes from the end node to the other.
struct EndWeights {
    double first, second;
};
EndWeights end_weights(std::size_t element, std::size_t elements);
/// Adds to the external loads of both nodes of an element, by those weights.
void add_to_element(Rod& rod, std::size_t element, const Vec3d& force);

inline Vec3d mean_velocity(const Rod& rod, std::size_t element) {
    return 0.5 * (rod.velocity(element) + rod.velocity(element + 1));
}

} // namespace skein::replay
