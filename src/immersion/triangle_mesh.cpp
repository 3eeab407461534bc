#include "immersion/triangle_mesh.hpp"

#include "fluid/fluid_grid.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace skein {

namespace {

Vec3d lesser(const Vec3d& a, const Vec3d& b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3d greater(const Vec3d& a, const Vec3d& b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

bool before(const Vec3d& a, const Vec3d& b) { return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z; }
bool same(const Vec3d& a, const Vec3d& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
bool finite(const Vec3d& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

std::string text_of(const Vec3d& a) { return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", a.x, a.y, a.z); }

double squared_distance(const TriangleTree::Box& box, const Vec3d& place) {
    const Vec3d out = greater(greater(box.lower - place, place - box.upper), {0, 0, 0});
    return dot(out, out);
}
bool meet(const TriangleTree::Box& a, const TriangleTree::Box& b) {
    return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y && b.lower.y <= a.upper.y &&
           a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

/// Six times the volume of a tetrahedron.
double volume_of(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    return dot(d - a, cross(b - a, c - a));
}

/// True where the line from p to q goes through a triangle, not along it.
bool pierces(const Vec3d& p, const Vec3d& q, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const double from = volume_of(a, b, c, p), to = volume_of(a, b, c, q);
    if (!(from * to < 0)) return false;
    const double ab = volume_of(p, q, a, b), bc = volume_of(p, q, b, c), ca = volume_of(p, q, c, a);
    return (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
}

} // namespace

TriangleTree::TriangleTree(std::span<const Box> of_triangles) : triangle_(of_triangles.size()) {
    std::iota(triangle_.begin(), triangle_.end(), 0u);
    if (!triangle_.empty()) build(of_triangles, 0, static_cast<std::uint32_t>(triangle_.size()));
}

void TriangleTree::build(std::span<const Box> of_triangles, std::uint32_t from, std::uint32_t to) {
    const std::size_t own = nodes_.size();
    Box box = of_triangles[triangle_[from]];
    for (std::uint32_t i = from; i < to; ++i) {
        box.lower = lesser(box.lower, of_triangles[triangle_[i]].lower);
        box.upper = greater(box.upper, of_triangles[triangle_[i]].upper);
    }
    nodes_.push_back({box, from, to - from});
    if (to - from <= most_in_leaf) return;
    const Vec3d size = box.upper - box.lower;
    const int d = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto middle = [&](std::uint32_t t) {
        return component_of(of_triangles[t].lower, d) + component_of(of_triangles[t].upper, d);
    };
    const std::uint32_t half = from + (to - from) / 2;
    std::nth_element(triangle_.begin() + from, triangle_.begin() + half, triangle_.begin() + to,
                     [&](std::uint32_t a, std::uint32_t b) {
                         const double x = middle(a), y = middle(b);
                         return x != y ? x < y : a < b;
                     });
    nodes_[own].count = 0;
    build(of_triangles, from, half);
    nodes_[own].first = static_cast<std::uint32_t>(nodes_.size());
    build(of_triangles, half, to);
}

template <class Visit> void TriangleTree::for_nearest(const Vec3d& place, double squared, Visit&& visit) const {
    struct Open {
        std::uint32_t node;
        double squared;
    };
    std::array<Open, 64> open; // one for each level of halves
    std::size_t count = 0;
    open[count++] = {0, squared_distance(nodes_[0].box, place)};
    while (count > 0) {
        const Open next = open[--count];
        if (next.squared > squared) continue;
        const Node& node = nodes_[next.node];
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) squared = visit(triangle_[i]);
        if (node.count > 0) continue;
        Open near{next.node + 1, squared_distance(nodes_[next.node + 1].box, place)},
            far{node.first, squared_distance(nodes_[node.first].box, place)};
        if (far.squared < near.squared) std::swap(near, far);
        open[count++] = far;
        open[count++] = near;
    }
}

template <class Visit> void TriangleTree::for_meeting(const Box& box, Visit&& visit) const {
    std::vector<std::uint32_t> open(1, 0);
    while (!open.empty()) {
        const std::uint32_t at = open.back();
        open.pop_back();
        const Node& node = nodes_[at];
        if (!meet(node.box, box)) continue;
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(triangle_[i]);
        if (node.count > 0) continue;
        open.push_back(node.first);
        open.push_back(at + 1);
    }
}

TriangleMesh::TriangleMesh(std::vector<Vec3d> points, std::vector<Triangle> triangles, const Where& where)
    : points_(std::move(points)), triangles_(std::move(triangles)) {
    merge_points(where);
    close(where);
    find_normals();
    std::vector<TriangleTree::Box> boxes;
    for (std::size_t t = 0; t < triangles_.size(); ++t) boxes.push_back(box_of(t));
    tree_ = TriangleTree(boxes);
    refuse_crossings(where);
    refuse_wrong_sides(where);
    find_solid();
}

void TriangleMesh::merge_points(const Where& where) {
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        for (int i = 0; i < 3; ++i)
            if (!finite(corner(t, i)))
                throw InputError(
                    fmt::format("{}: a corner is at {}: coordinates must be finite", where(t), text_of(corner(t, i))));
    std::vector<std::uint32_t> order(points_.size()), to(points_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return same(points_[a], points_[b]) ? a < b : before(points_[a], points_[b]);
    });
    std::vector<Vec3d> kept;
    for (const std::uint32_t p : order) {
        if (kept.empty() || !same(kept.back(), points_[p])) kept.push_back(points_[p]);
        to[p] = static_cast<std::uint32_t>(kept.size() - 1);
    }
    std::vector<Triangle> all;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const auto [a, b, c] = triangles_[t];
        const Triangle merged{to[a], to[b], to[c]};
        if (merged[0] == merged[1] || merged[1] == merged[2] || merged[2] == merged[0]) continue;
        all.push_back(merged);
        given_.push_back(t);
    }
    points_ = std::move(kept);
    triangles_ = std::move(all);
}

std::vector<TriangleMesh::Edge> TriangleMesh::sorted_edges() const {
    std::vector<Edge> edges;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t from = triangles_[t][i], to = triangles_[t][(i + 1) % 3];
            edges.push_back({std::min(from, to), std::max(from, to), static_cast<std::uint32_t>(t),
                             static_cast<std::uint8_t>(i), from < to});
        }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
        return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
    });
    return edges;
}

void TriangleMesh::close(const Where& where) {
    if (triangles_.size() < 4)
        throw InputError(fmt::format("{} triangles with an area cannot enclose a body: at least 4", triangles_.size()));
    to_.resize(triangles_.size());
    const std::vector<Edge> edges = sorted_edges();
    for (std::size_t e = 0, next = 0; e < edges.size(); e = next) {
        const Edge &one = edges[e], &other = edges[std::min(e + 1, edges.size() - 1)];
        while (next < edges.size() && edges[next].low == one.low && edges[next].high == one.high) ++next;
        const auto refuse = [&](const std::string& what, const char* cure) {
            throw InputError(fmt::format("{}: the edge from {} to {} {}: {}", where(given_[one.triangle]),
                                         text_of(points_[one.low]), text_of(points_[one.high]), what, cure));
        };
        if (next - e == 1) refuse("belongs to this triangle alone", "close the surface, which encloses no body");
        if (next - e > 2)
            refuse(fmt::format("belongs to {} triangles", next - e),
                   "separate bodies that touch along an edge, or join them to one surface");
        if (one.forward == other.forward)
            refuse(fmt::format("has the same direction in the triangle beside it ({})", where(given_[other.triangle])),
                   "turn one of them: corners are counter-clockwise as seen from outside");
        to_[one.triangle][one.side] = other.triangle;
        to_[other.triangle][other.side] = one.triangle;
    }
}

void TriangleMesh::find_normals() {
    at_point_.assign(points_.size(), {0, 0, 0});
    lower_ = upper_ = corner(0, 0);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const Vec3d twice = cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
        const double area = norm(twice);
        normal_.push_back(area > 0 ? (1 / area) * twice : Vec3d{0, 0, 0});
        for (int i = 0; i < 3; ++i) {
            const Vec3d here = corner(t, i), a = corner(t, (i + 1) % 3) - here, b = corner(t, (i + 2) % 3) - here;
            at_point_[nth(triangles_[t], i)] += std::atan2(norm(cross(a, b)), dot(a, b)) * normal_[t];
            lower_ = lesser(lower_, here);
            upper_ = greater(upper_, here);
        }
    }
}

TriangleTree::Box TriangleMesh::box_of(std::size_t t) const {
    return {lesser(lesser(corner(t, 0), corner(t, 1)), corner(t, 2)),
            greater(greater(corner(t, 0), corner(t, 1)), corner(t, 2))};
}

void TriangleMesh::refuse_crossings(const Where& where) const {
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        for (int side = 0; side < 3; ++side) {
            const std::uint32_t from = nth(triangles_[t], side), to = nth(triangles_[t], (side + 1) % 3);
            if (from > to) continue; // the triangle beyond has it
            const Vec3d &p = points_[from], &q = points_[to];
            tree_.for_meeting({lesser(p, q), greater(p, q)}, [&](std::uint32_t other) {
                for (const std::uint32_t at : triangles_[other])
                    if (at == from || at == to) return;
                if (pierces(p, q, corner(other, 0), corner(other, 1), corner(other, 2)))
                    throw InputError(fmt::format("{}: this triangle goes through another one ({}) near {}: join both "
                                                 "bodies to one surface without crossings",
                                                 where(given_[t]), where(given_[other]), text_of(0.5 * (p + q))));
            });
        }
}

void TriangleMesh::refuse_wrong_sides(const Where& where) const {
    std::vector<std::uint32_t> shell(triangles_.size(), 0); // numbers from 1
    std::vector<std::size_t> first;
    std::vector<double> volume;
    for (std::size_t begin = 0; begin < triangles_.size(); ++begin) {
        if (shell[begin] > 0) continue;
        first.push_back(begin);
        volume.push_back(0);
        std::vector<std::size_t> open(1, begin);
        shell[begin] = static_cast<std::uint32_t>(first.size());
        while (!open.empty()) {
            const std::size_t t = open.back();
            open.pop_back();
            volume.back() += volume_of(corner(begin, 0), corner(t, 0), corner(t, 1), corner(t, 2)) / 6;
            for (const std::uint32_t beyond : to_[t])
                if (shell[beyond] == 0) {
                    shell[beyond] = shell[begin];
                    open.push_back(beyond);
                }
        }
    }
    // Signed crossings of a ray from a shell with the other shells count how many of them it is within.
    const double far = 2 * norm(upper_ - lower_);
    for (std::size_t s = 0; s < first.size(); ++s) {
        const std::size_t t = first[s];
        const Vec3d from = (1.0 / 3) * (corner(t, 0) + corner(t, 1) + corner(t, 2)),
                    to = from + far * Vec3d{0.3713906763541037, 0.5570860145311556, 0.7427813527082074};
        int within = 0;
        if (first.size() > 1)
            tree_.for_meeting({lesser(from, to), greater(from, to)}, [&](std::uint32_t other) {
                const Vec3d a = corner(other, 0), b = corner(other, 1), c = corner(other, 2);
                if (shell[other] != s + 1 && pierces(from, to, a, b, c)) within += volume_of(a, b, c, to) > 0 ? 1 : -1;
            });
        const bool good = (within == 0 && volume[s] > 0) || (within == 1 && volume[s] < 0);
        if (!good)
            throw InputError(fmt::format(
                "{}: the closed surface of this triangle encloses {:.6g} m^3{}: turn its triangles, whose corners are "
                "counter-clockwise as seen from outside{}",
                where(given_[t]), volume[s], within > 0 ? " within another one" : "",
                within > 0 ? ", or clockwise around a hollow" : ""));
    }
}

void TriangleMesh::find_solid() {
    const Vec3d origin = 0.5 * (lower_ + upper_);
    double volume = 0;
    Vec3d first{0, 0, 0};
    SymmetricMatrix second;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const Vec3d a = corner(t, 0) - origin, b = corner(t, 1) - origin, c = corner(t, 2) - origin, s = a + b + c;
        const double v = dot(a, cross(b, c)) / 6; // theory.md (150)
        volume += v;
        first += (0.25 * v) * s;
        const auto moment = [&](int i, int j) {
            const auto product = [&](const Vec3d& p) { return component_of(p, i) * component_of(p, j); };
            return v / 20 * (product(a) + product(b) + product(c) + product(s));
        };
        second += {moment(0, 0), moment(1, 1), moment(2, 2), moment(0, 1), moment(0, 2), moment(1, 2)};
    }
    const Vec3d m = (1 / volume) * first;
    const auto centred = [&](double of, double p, double q) { return of / volume - p * q; };
    const double xx = centred(second.xx, m.x, m.x), yy = centred(second.yy, m.y, m.y),
                 zz = centred(second.zz, m.z, m.z);
    solid_ = {volume,
              origin + m,
              {yy + zz, xx + zz, xx + yy, -centred(second.xy, m.x, m.y), -centred(second.xz, m.x, m.z),
               -centred(second.yz, m.y, m.z)}};
}

/// By the regions of its plane: those of corners, then edges, then the inner one.
TriangleMesh::Nearest TriangleMesh::nearest(std::size_t t, const Vec3d& place) const {
    const Vec3d a = corner(t, 0), ab = corner(t, 1) - a, ac = corner(t, 2) - a, from = place - a;
    const auto found = [&](double v, double w, int part) -> Nearest {
        const Vec3d off = from - v * ab - w * ac;
        return {place - off, dot(off, off), part};
    };
    const double d1 = dot(ab, from), d2 = dot(ac, from);
    if (d1 <= 0 && d2 <= 0) return found(0, 0, 4);
    const Vec3d of_b = from - ab, of_c = from - ac;
    const double d3 = dot(ab, of_b), d4 = dot(ac, of_b), d5 = dot(ab, of_c), d6 = dot(ac, of_c);
    if (d3 >= 0 && d4 <= d3) return found(1, 0, 5);
    if (d6 >= 0 && d5 <= d6) return found(0, 1, 6);
    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return found(d1 / (d1 - d3), 0, 1);
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return found(0, d2 / (d2 - d6), 3);
    if (va <= 0 && d4 >= d3 && d5 >= d6) {
        const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return found(1 - w, w, 2);
    }
    const double all = 1 / (va + vb + vc);
    return found(vb * all, vc * all, 0);
}

Vec3d TriangleMesh::normal(std::size_t t, int part) const {
    if (part == 0) return normal_[t];
    if (part <= 3) return normal_[t] + normal_[nth(to_[t], part - 1)];
    return at_point_[nth(triangles_[t], part - 4)];
}

double TriangleMesh::distance(const Vec3d& place) const {
    Nearest best{{0, 0, 0}, HUGE_VAL, 0};
    std::size_t of = 0;
    tree_.for_nearest(place, HUGE_VAL, [&](std::uint32_t t) {
        const Nearest here = nearest(t, place);
        if (here.squared < best.squared || (here.squared == best.squared && t < of)) {
            best = here;
            of = t;
        }
        return best.squared;
    });
    const double away = std::sqrt(best.squared);
    return dot(place - best.at, normal(of, best.part)) < 0 ? -away : away;
}

double TriangleMesh::reach() const {
    double most = 0;
    for (const Vec3d& p : points_) most = std::max(most, norm(p));
    return most;
}

} // namespace skein
