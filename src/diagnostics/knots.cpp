#include "diagnostics/knots.hpp"

#include <cmath>
#include <numbers>

namespace skein {

namespace {

using std::numbers::pi;

std::size_t segments(std::span<const Vec3d> node, Curve curve) {
    return curve == Curve::closed ? node.size() : node.size() - 1;
}

const Vec3d& after(std::span<const Vec3d> node, std::size_t i) { return node[i + 1 < node.size() ? i + 1 : 0]; }

/// Gauss's integral over two straight segments, 1 to 2 and 3 to 4. It is the solid angle of the parallelogram of all
/// vectors between them, over 4 pi. Two triangles make the parallelogram, with one triple product. Each has
/// tan(Omega/2) = a.(b x c)/(|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|) (van Oosterom & Strackee 1983).
double segment_pair(const Vec3d& x1, const Vec3d& x2, const Vec3d& x3, const Vec3d& x4) {
    const Vec3d a = x3 - x1, b = x4 - x1, c = x4 - x2, d = x3 - x2;
    const double na = norm(a), nb = norm(b), nc = norm(c), nd = norm(d);
    const double volume = dot(a, cross(x4 - x3, x2 - x1)), ac = dot(a, c);
    const double first = na * nb * nc + dot(a, b) * nc + dot(b, c) * na + ac * nb;
    const double second = na * nc * nd + ac * nd + dot(c, d) * na + dot(d, a) * nc;
    return (std::atan2(volume, first) + std::atan2(volume, second)) / (2 * pi);
}

/// Sum of nodes from first to last (not included), over `weight`.
Vec3d mean(std::span<const Vec3d> node, std::size_t first, std::size_t last, std::size_t weight) {
    Vec3d sum{0, 0, 0};
    for (std::size_t i = first; i < last; ++i) sum += node[i];
    return (1 / static_cast<double>(weight)) * sum;
}

struct Ends {
    Vec3d first, last; ///< unit vectors away from the rod
};

Ends end_directions(std::span<const Vec3d> node, EndSegments kind) {
    const std::size_t n = node.size();
    if (kind == EndSegments::next_tangent) return {unit(node[0] - node[1]), unit(node[n - 1] - node[n - 2])};
    Vec3d first = node[0] - node[n - 1];
    if (kind == EndSegments::net_tangent) {
        // The published mean of the second half divides by one node too many.
        const std::size_t half = n / 2, from = (n + 1) / 2;
        first = mean(node, 0, half, half) - mean(node, from, n, n - from + 1);
    }
    first = unit(first);
    return {first, -first};
}

std::vector<Vec3d> prolonged(std::span<const Vec3d> node, double length, const Ends& ends) {
    std::vector<Vec3d> out{node.front() + length * ends.first};
    out.insert(out.end(), node.begin(), node.end());
    out.push_back(node.back() + length * ends.last);
    return out;
}

/// d1 without its part along the segment.
Vec3d normal_part(const Vec3d& d1, const Vec3d& tangent) { return d1 - dot(d1, tangent) * tangent; }

} // namespace

std::vector<Vec3d> with_end_segments(std::span<const Vec3d> node, double length, EndSegments kind) {
    if (kind == EndSegments::none) return {node.begin(), node.end()};
    return prolonged(node, length, end_directions(node, kind));
}

std::vector<double> local_twist(std::span<const Vec3d> node, std::span<const Vec3d> d1, Curve curve) {
    const std::size_t n = segments(node, curve), vertices = curve == Curve::closed ? n : n - 1;
    std::vector<double> turns(vertices);
    for (std::size_t i = 0; i < vertices; ++i) {
        const std::size_t next = i + 1 < n ? i + 1 : 0;
        const Vec3d t = unit(after(node, i) - node[i]), u = unit(after(node, next) - node[next]);
        const Vec3d axis = cross(t, u), v = normal_part(d1[i], t);
        const Vec3d turned = cross(axis, v);
        const Vec3d carried = v + turned + (1 / (1 + dot(t, u))) * cross(axis, turned);
        turns[i] = std::atan2(dot(cross(carried, d1[next]), u), dot(carried, normal_part(d1[next], u))) / (2 * pi);
    }
    return turns;
}

double twist(std::span<const Vec3d> node, std::span<const Vec3d> d1, Curve curve) {
    double sum = 0;
    for (const double turn : local_twist(node, d1, curve)) sum += turn;
    return sum;
}

double writhe(std::span<const Vec3d> node, Curve curve) {
    const std::size_t n = segments(node, curve);
    double sum = 0;
    for (std::size_t i = 0; i + 2 < n; ++i)
        for (std::size_t j = i + 2; j < n; ++j) {
            if (curve == Curve::closed && i == 0 && j == n - 1) continue; // neighbours lie in a plane
            sum += segment_pair(node[i], node[i + 1], node[j], after(node, j));
        }
    return 2 * sum;
}

double linking(std::span<const Vec3d> a, Curve curve_a, std::span<const Vec3d> b, Curve curve_b) {
    double sum = 0;
    for (std::size_t i = 0; i < segments(a, curve_a); ++i)
        for (std::size_t j = 0; j < segments(b, curve_b); ++j)
            sum += segment_pair(a[i], after(a, i), b[j], after(b, j));
    return sum;
}

double auxiliary_link(std::span<const Vec3d> node, std::span<const Vec3d> d1, std::span<const double> radius,
                      double length, EndSegments kind) {
    std::vector<Vec3d> auxiliary(node.begin(), node.end());
    for (std::size_t i = 0; i < node.size(); ++i) {
        const std::size_t k = i == 0 ? 0 : i - 1;
        auxiliary[i] += radius[k] * unit(normal_part(d1[k], unit(node[k + 1] - node[k])));
    }
    if (kind == EndSegments::none) return linking(node, Curve::open, auxiliary, Curve::open);
    const Ends ends = end_directions(node, kind);
    return linking(prolonged(node, length, ends), Curve::open, prolonged(auxiliary, length, ends), Curve::open);
}

} // namespace skein
