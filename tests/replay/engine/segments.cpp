#include "segments.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein::replay {

namespace {

double within_segment(double share) { return std::clamp(share, 0.0, 1.0); }

} // namespace

std::vector<Segment> segments_of(const Rod& rod) {
    std::vector<Segment> segments;
    for (std::size_t k = 0; k < rod.elements(); ++k) {
        const Vec3d start = rod.position(k), edge = rod.position(k + 1) - start;
        const double length = norm(edge) + 1e-14;
        segments.push_back({start, edge, length, std::sqrt(rod.group.element[k].volume / (std::numbers::pi * length))});
    }
    return segments;
}

// |r + s b - t a|, r from start to start, is least where  t a.a - s a.b = r.a  and  t a.b - s b.b = r.b;  where s or t
// leaves [0, 1] the nearest of the four pairs of an end and the other segment. Nearly parallel: from the start of b.
Nearest nearest(const Vec3d& start_a, const Vec3d& edge_a, const Vec3d& start_b, const Vec3d& edge_b) {
    const Vec3d r = start_b - start_a;
    const double aa = dot(edge_a, edge_a), ab = dot(edge_a, edge_b), bb = dot(edge_b, edge_b), ra = dot(r, edge_a),
                 rb = dot(r, edge_b);
    const auto between = [&](double t, double s) { return r + s * edge_b - t * edge_a; };
    double t, s;
    if (std::abs(1 - ab * ab / (aa * bb)) < 1e-6) {
        t = within_segment(ra / aa);
        s = within_segment((t * ab - rb) / bb);
    } else {
        s = (ab * ra - aa * rb) / (aa * bb - ab * ab);
        t = (ab * s + ra) / aa;
        if (s < 0 || s > 1 || t < 0 || t > 1) {
            const struct {
                double t, s;
            } pairs[] = {{within_segment(ra / aa), 0},
                         {within_segment((ra + ab) / aa), 1},
                         {0, within_segment(-rb / bb)},
                         {1, within_segment((ab - rb) / bb)}};
            double least = INFINITY;
            for (const auto& pair : pairs)
                if (const double distance = norm(between(pair.t, pair.s)); distance < least) {
                    least = distance;
                    t = pair.t;
                    s = pair.s;
                }
        }
    }
    return {between(t, s), start_b + s * edge_b};
}

bool Box::apart_from(const Box& b) const {
    return upper.x < b.lower.x || upper.y < b.lower.y || upper.z < b.lower.z || b.upper.x < lower.x ||
           b.upper.y < lower.y || b.upper.z < lower.z;
}

Box box_of(const Rod& rod, double reach) {
    Box box{rod.position(0), rod.position(0)};
    for (std::size_t i = 1; i < rod.nodes(); ++i) {
        const Vec3d x = rod.position(i);
        box.lower = {std::min(box.lower.x, x.x), std::min(box.lower.y, x.y), std::min(box.lower.z, x.z)};
        box.upper = {std::max(box.upper.x, x.x), std::max(box.upper.y, x.y), std::max(box.upper.z, x.z)};
    }
    const Vec3d wider{reach, reach, reach};
    return {box.lower - wider, box.upper + wider};
}

double largest_radius(const std::vector<Segment>& segments) {
    return std::max_element(segments.begin(), segments.end(),
                            [](const Segment& a, const Segment& b) { return a.radius < b.radius; })
        ->radius;
}
double largest_length(const std::vector<Segment>& segments) {
    return std::max_element(segments.begin(), segments.end(),
                            [](const Segment& a, const Segment& b) { return a.length < b.length; })
        ->length;
}

EndWeights end_weights(std::size_t element, std::size_t elements) {
    if (element == 0) return {2.0 / 3, 4.0 / 3};
    if (element + 1 == elements) return {4.0 / 3, 2.0 / 3};
    return {1, 1};
}

void add_to_element(Rod& rod, std::size_t k, const Vec3d& force) {
    const EndWeights weight = end_weights(k, rod.elements());
    rod.external[k].force += broadcast<1>(weight.first * force);
    rod.external[k + 1].force += broadcast<1>(weight.second * force);
}

} // namespace skein::replay
