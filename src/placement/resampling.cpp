#include "placement/resampling.hpp"

#include "core/fused.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace skein {

namespace {

constexpr double longest_tangent = 2;

Vec3d limited(const Vec3d& tangent) {
    const double size = norm(tangent);
    return size > longest_tangent ? (longest_tangent / size) * tangent : tangent;
}

/// Share of an edge from a to b at which it is nearest to p.
double nearest_share(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
    const Vec3d edge = b - a;
    const double square = dot(edge, edge);
    return square > 0 ? std::clamp(dot(p - a, edge) / square, 0.0, 1.0) : 0.0;
}

} // namespace

SKEIN_FUSED void PointCurve::pass_through(std::span<const Vec3d> points) {
    points_ = points;
    const std::size_t pieces = points.size() - 1;
    chord_.resize(pieces);
    way_.resize(pieces);
    arc_.resize(pieces);
    for (std::size_t i = 0; i < pieces; ++i) {
        const Vec3d edge = points[i + 1] - points[i];
        chord_[i] = norm(edge);
        way_[i] = (1 / chord_[i]) * edge;
    }
    find_tangents();
    limit_tangents();
    length_ = 0;
    for (std::size_t i = 0; i < pieces; ++i) {
        arc_[i] = piece_length(i);
        length_ += arc_[i];
    }
}

/// Derivative at an end of the polynomial through the first four points from there, or through all of fewer points.
Vec3d PointCurve::end_tangent(std::size_t end, int way) const {
    const std::size_t pieces = chord_.size();
    const auto piece = [&](std::size_t k) { return way > 0 ? k : end - 1 - k; };
    const auto h = [&](std::size_t k) { return chord_[piece(k)]; };
    const auto d = [&](std::size_t k) { return way_[piece(k)]; };
    if (pieces == 1) return d(0);
    const Vec3d second = (1 / (h(0) + h(1))) * (d(1) - d(0));
    Vec3d tangent = d(0) - h(0) * second;
    if (pieces > 2) {
        const Vec3d next = (1 / (h(1) + h(2))) * (d(2) - d(1));
        tangent = tangent + (h(0) * (h(0) + h(1)) / (h(0) + h(1) + h(2))) * (next - second);
    }
    return tangent;
}

void PointCurve::find_tangents() {
    const std::size_t last = points_.size() - 1;
    tangent_.resize(last + 1);
    upper_.resize(last + 1);
    tangent_[0] = limited(end_tangent(0, 1));
    tangent_[last] = limited(end_tangent(last, -1));
    upper_[0] = 0;
    for (std::size_t i = 1; i < last; ++i) { // divided by h_i-1 + h_i, so that no sum overflows
        const double before = chord_[i - 1] / (chord_[i - 1] + chord_[i]), after = 1 - before;
        const double pivot = 1 / (2 - after * upper_[i - 1]);
        upper_[i] = before * pivot;
        tangent_[i] = pivot * (3 * (after * way_[i - 1] + before * way_[i]) - after * tangent_[i - 1]);
    }
    for (std::size_t i = last; i-- > 1;) tangent_[i] = tangent_[i] - upper_[i] * tangent_[i + 1];
}

void PointCurve::limit_tangents() {
    for (Vec3d& m : tangent_) m = limited(m);
}

SKEIN_FUSED Vec3d PointCurve::at(const Place& place) const {
    const std::size_t i = place.piece;
    const double t = place.share;
    const Vec3d &a = tangent_[i], &b = tangent_[i + 1], &d = way_[i];
    return points_[i] + (t * chord_[i]) * (a + t * (3 * d - 2 * a - b + t * (a + b - 2 * d)));
}

/// Gauss's rule with four points.
double PointCurve::piece_length(std::size_t i) const {
    constexpr std::array<double, 2> offset = {0.33998104358485626, 0.86113631159405258},
                                    weight = {0.65214515486254614, 0.34785484513745386};
    const Vec3d &a = tangent_[i], &b = tangent_[i + 1], &d = way_[i];
    const Vec3d linear = 2 * (3 * d - 2 * a - b), square = 3 * (a + b - 2 * d);
    double sum = 0;
    for (std::size_t g = 0; g < 2; ++g)
        for (const double x : {-offset[g], offset[g]}) {
            const double t = 0.5 + 0.5 * x;
            sum += 0.5 * weight[g] * norm(a + t * (linear + t * square));
        }
    return chord_[i] * std::max(sum, 1.0); // no arc is shorter than its chord
}

/// The arc length over the share is a cubic with the right ends and end slopes: an error of fourth order, which moves
/// nodes along the curve alone. Its slopes at the ends are at most twice the mean, so it rises.
double PointCurve::share_of_length(std::size_t piece, double s) const {
    const double whole = arc_[piece], target = s / whole;
    const double a = norm(tangent_[piece]) * chord_[piece] / whole,
                 b = norm(tangent_[piece + 1]) * chord_[piece] / whole;
    double low = 0, high = 1, t = target;
    for (int round = 0; round < 60; ++round) {
        const double value = t * (a + t * (3 - 2 * a - b + t * (a + b - 2))) - target;
        const double slope = a + t * (2 * (3 - 2 * a - b) + 3 * t * (a + b - 2));
        (value > 0 ? high : low) = t;
        const double newton = t - value / slope;
        const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
        if (std::abs(next - t) < 1e-14) return next;
        t = next;
    }
    return t;
}

SKEIN_FUSED void PointCurve::cut(std::size_t elements, std::vector<Place>& places) const {
    places.clear();
    places.push_back({0, 0.0});
    std::size_t piece = 0;
    double begin = 0; // arc length at which the piece begins
    for (std::size_t k = 1; k < elements; ++k) {
        const double s = length_ * (static_cast<double>(k) / static_cast<double>(elements));
        while (piece + 1 < arc_.size() && begin + arc_[piece] < s) begin += arc_[piece++];
        places.push_back({piece, share_of_length(piece, std::clamp(s - begin, 0.0, arc_[piece]))});
    }
    places.push_back({arc_.size() - 1, 1.0});
}

SKEIN_FUSED double PointCurve::deviation(std::span<const Place> places, std::span<const Vec3d> nodes) const {
    double largest = 0; // square
    const auto take = [&](const Vec3d& a, const Vec3d& b) { largest = std::max(largest, dot(a - b, a - b)); };
    std::size_t piece = 0;
    double on_piece = 0; // partner of the last node on its piece: partners never go back
    for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
        double on_edge = 0;
        for (std::size_t i = places[k].piece + 1; i <= places[k + 1].piece; ++i) {
            on_edge = std::max(on_edge, nearest_share(points_[i], nodes[k], nodes[k + 1]));
            take(points_[i], nodes[k] + on_edge * (nodes[k + 1] - nodes[k]));
        }
        const Place& next = places[k + 1];
        const bool last = k + 2 == nodes.size();
        const double nearest = last ? 1.0 : nearest_share(nodes[k + 1], points_[next.piece], points_[next.piece + 1]);
        on_piece = next.piece == piece ? std::max(on_piece, nearest) : nearest;
        piece = next.piece;
        take(nodes[k + 1], points_[piece] + on_piece * (points_[piece + 1] - points_[piece]));
    }
    return std::sqrt(largest);
}

namespace {

template <class T> T linear(const PointCurve::Place& place, std::span<const T> values) {
    return (1 - place.share) * values[place.piece] + place.share * values[place.piece + 1];
}

} // namespace

double value_at(const PointCurve::Place& place, std::span<const double> of_points) { return linear(place, of_points); }
Vec3d value_at(const PointCurve::Place& place, std::span<const Vec3d> of_points) { return linear(place, of_points); }

} // namespace skein
