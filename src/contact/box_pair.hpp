// Two rounded boxes: features that are near each other, and what share of the contact each has.  theory.md (59f)-(59h)
//   features   vertices of either with the other box; edges that cross
//   overlap    g = r1 + r2 - d of each; x = g^4, x_j of features that belong to it
//   vertex     T = x (1 + product(1 - x_j/x))/2     j: vertices of the other box, each with this vertex alone
//   edges      T = x product(1 - x_j/x)             j: ends of both, each with the other edge
//   all        G = (sum T)^(1/4); the spring of the contact is pressed by G
// A point that two features share counts once, so G is continuous as a vertex leaves a face over its edge. Vertices
// and edges in other places have the same distance as these wherever one is nearest. Sharp boxes must not meet.
// Cost: 600 flop for boxes that are apart, some 10 000 for two faces.
#pragma once

#include "contact/box_distance.hpp"
#include "contact/contact_solver.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

namespace skein {

/// A box without its rounding; lab. Over doubles, or over numbers with their slopes.
template <class P> struct BoxInPlace {
    Vec3<P> centre; ///< m
    Mat3<P> axes;
    Vec3d half; ///< m

    Vec3<P> inwards(const Vec3<P>& place) const { return axes * (place - centre); }
    /// Half of its extent along a direction.
    double extent(const Vec3d& along) const requires std::is_same_v<P, double> {
        const Vec3d c = axes * along;
        return std::abs(c.x) * half.x + std::abs(c.y) * half.y + std::abs(c.z) * half.z;
    }
    Vec3<P> vertex(unsigned bits) const { return centre + transpose_times(axes, constant<P>(box_vertex(half, bits))); }
    bool flat(int axis) const { return (axis == 0 ? half.x : axis == 1 ? half.y : half.z) == 0; }
    bool repeats(unsigned bits) const { return repeats_vertex(half, bits); }
    BoxInPlace<double> value() const {
        return {values_of(centre), {values_of(axes.d1), values_of(axes.d2), values_of(axes.d3)}, half};
    }
};
using PlacedBox = BoxInPlace<double>;

/// A box of an exposure; places are from `origin` on. Its axes: neighbourhood/surface.hpp.
inline PlacedBox placed_box(const Exposure& bodies, std::uint32_t slot, const PartBox& box, const Vec3d& origin) {
    const ExposedMotion& shown = bodies.motion[slot + 1];
    return {
        bodies.node[slot].position - origin, {shown.velocity, shown.spin, cross(shown.velocity, shown.spin)}, box.half};
}

/// Largest distance of two boxes along any direction that could part them, m; below 0 where they intersect. Directions
/// of faces, and without `all` these alone.
inline double separation(const PlacedBox& one, const PlacedBox& two, bool all) {
    const Vec3d apart = two.centre - one.centre, a[3] = {one.axes.d1, one.axes.d2, one.axes.d3},
                b[3] = {two.axes.d1, two.axes.d2, two.axes.d3};
    double most = -HUGE_VAL;
    const auto take = [&](const Vec3d& n) {
        most = std::max(most, std::abs(dot(apart, n)) - one.extent(n) - two.extent(n));
    };
    for (const Vec3d& n : a) take(n);
    for (const Vec3d& n : b) take(n);
    if (!all) return most;
    for (const Vec3d& u : a)
        for (const Vec3d& v : b)
            if (const Vec3d n = cross(u, v); dot(n, n) > 1e-12) take(unit(n));
    return most;
}

/// Nearest points of two features, one of each box.
template <class P> struct GapOfBoxes {
    Vec3<P> on_1, on_2, normal; ///< lab; from 1 to 2
    P distance;                 ///< m
};
using BoxGap = GapOfBoxes<double>;

template <class P> class MeetingOfBoxes {
public:
    using BoxGap = GapOfBoxes<P>;
    using PlacedBox = BoxInPlace<P>;
    struct Touch {
        BoxGap gap;
        P overlap; ///< g, m
        P share;   ///< T/x
    };
    /// Force on the first box, and couples on both about their centres.
    struct Wrench {
        Vec3<P> force = constant<P>({0, 0, 0}), couple_1 = force, couple_2 = force;

        void add(const BoxGap& gap, const Vec3<P>& centre_1, const Vec3<P>& centre_2, const P& pressure) {
            const Vec3<P> on_1 = -pressure * gap.normal;
            force += on_1;
            couple_1 += cross(gap.on_1 - centre_1, on_1);
            couple_2 -= cross(gap.on_2 - centre_2, on_1);
        }
    };

    MeetingOfBoxes(const PlacedBox& one, const PlacedBox& two, double reach) : one_(one), two_(two), reach_(reach) {
        if (separation(one.value(), two.value(), false) >= reach) return;
        find_vertices(one_, two_, false);
        find_vertices(two_, one_, true);
        add_vertices();
        add_edges();
        overlap_ = sqrt(sqrt(sum_));
    }

    std::span<const Touch> touches() const { return {touch_.data(), count_}; }
    const P& overlap() const { return overlap_; } ///< G, m
    const P& deepest() const { return deepest_; } ///< the largest g, m
    /// Forces as shares change, over dE/dG/G^3.
    const Wrench& change() const { return change_; }

private:
    /// A vertex of one box in touch with the other.
    struct Vertex {
        Vec3<P> place;
        BoxGap gap;
        P overlap, power; ///< g, x
    };
    /// A feature that belongs to another one.
    struct Part {
        BoxGap gap;
        P overlap, power;
    };
    struct Edge {
        Vec3<P> from, to;
    };

    static P at_least(double low, const P& x) { return low < value_of(x) ? x : P(low); }
    static P fourth(const P& g) { return (g * g) * (g * g); }

    void find_vertices(const PlacedBox& of, const PlacedBox& other, bool second) {
        for (unsigned bits = 0; bits < 8; ++bits) {
            if (of.repeats(bits)) continue;
            const Vec3<P> place = of.vertex(bits);
            const PointAtBox<P> near = nearest_on_box(other.inwards(place), other.half);
            const P g = reach_ - near.distance;
            if (!(value_of(g) > 0)) continue;
            const Vec3<P> foot = other.centre + transpose_times(other.axes, near.on_box),
                          outwards = transpose_times(other.axes, near.outwards);
            const BoxGap gap =
                second ? BoxGap{foot, place, outwards, near.distance} : BoxGap{place, foot, -outwards, near.distance};
            vertex_[second][vertices_[second]++] = {place, gap, g, fourth(g)};
        }
    }

    static BoxGap between(const Vec3<P>& at_1, const Vec3<P>& at_2) {
        const Vec3<P> apart = at_2 - at_1;
        const P distance = norm(apart);
        return {at_1, at_2, (1 / at_least(1e-150, distance)) * apart, distance};
    }
    /// Appends a feature that belongs to another one, if it is in touch.
    template <std::size_t most>
    void append(std::array<Part, most>& parts, std::size_t& count, const BoxGap& gap) const {
        if (const P g = reach_ - gap.distance; value_of(g) > 0) parts[count++] = {gap, g, fourth(g)};
    }

    void add_vertices() {
        for (const int side : {0, 1})
            for (std::size_t i = 0; i < vertices_[side]; ++i) {
                const Vertex& v = vertex_[side][i];
                std::array<Part, 8> parts;
                std::size_t count = 0;
                for (std::size_t j = 0; j < vertices_[1 - side]; ++j) {
                    const Vec3<P>& other = vertex_[1 - side][j].place;
                    append(parts, count, side == 0 ? between(v.place, other) : between(other, v.place));
                }
                add(v.gap, v.overlap, {parts.data(), count}, 0.5);
            }
    }

    /// Edges of a box that may come within reach of the other, by its vertices.
    std::size_t find_edges(const PlacedBox& of, const PlacedBox& other, std::array<Edge, 12>& edges) const {
        std::size_t count = 0;
        for (int axis = 0; axis < 3; ++axis) {
            if (of.flat(axis)) continue;
            for (unsigned bits = 0; bits < 8; ++bits) {
                if (bits >> axis & 1 || of.repeats(bits)) continue;
                const Edge edge{of.vertex(bits), of.vertex(bits | 1u << axis)};
                const Vec3d a = values_of(other.inwards(edge.from)), b = values_of(other.inwards(edge.to)),
                            h = other.half;
                const auto beyond = [&](double u, double v, double half) {
                    return std::min(u, v) >= half + reach_ || std::max(u, v) <= -half - reach_;
                };
                if (!beyond(a.x, b.x, h.x) && !beyond(a.y, b.y, h.y) && !beyond(a.z, b.z, h.z)) edges[count++] = edge;
            }
        }
        return count;
    }

    void add_edges() {
        std::array<Edge, 12> first, second;
        const std::size_t of_one = find_edges(one_, two_, first), of_two = of_one ? find_edges(two_, one_, second) : 0;
        for (std::size_t i = 0; i < of_one; ++i)
            for (std::size_t j = 0; j < of_two; ++j) add_crossing(first[i], second[j]);
    }

    /// Nearest point of an edge to a place.
    static Vec3<P> foot(const Edge& edge, const Vec3<P>& place) {
        const Vec3<P> along = edge.to - edge.from;
        const P s = clamped(P(dot(place - edge.from, along) / dot(along, along)), 0, 1);
        return fma(s, along, edge.from);
    }

    /// Edges whose nearest points are within both. Others are nearest where a vertex is, which has all of their share.
    void add_crossing(const Edge& e, const Edge& f) {
        const Vec3<P> d1 = e.to - e.from, d2 = f.to - f.from, r = e.from - f.from;
        const P a = dot(d1, d1), b = dot(d1, d2), c = dot(d2, d2), p = dot(d1, r), q = dot(d2, r),
                squared_sine = a * c - b * b;
        if (!(value_of(squared_sine) > 1e-14 * value_of(a) * value_of(c))) return;
        const P s = (b * q - c * p) / squared_sine, t = (a * q - b * p) / squared_sine;
        const auto within = [](double share) { return share > 0 && share < 1; };
        if (!within(value_of(s)) || !within(value_of(t))) return;
        BoxGap gap = between(fma(s, d1, e.from), fma(t, d2, f.from));
        const P g = reach_ - gap.distance;
        if (!(value_of(g) > 0)) return;
        std::array<Part, 4> parts;
        std::size_t count = 0;
        for (const Vec3<P>* end : {&e.from, &e.to}) append(parts, count, between(*end, foot(f, *end)));
        for (const Vec3<P>* end : {&f.from, &f.to}) append(parts, count, between(foot(e, *end), *end));
        add(gap, g, {parts.data(), count}, 1);
    }

    /// Adds T = x (1 - w + w product(1 - x_j/x)), and by derivatives of the rest of it the forces of its change.
    void add(const BoxGap& gap, const P& g, std::span<const Part> parts, double w) {
        const P x = fourth(g);
        P left = 1.0, slope = 0.0;
        for (const Part& part : parts) left *= at_least(0, 1 - part.power / x);
        for (const Part& part : parts) {
            P others = 1.0;
            for (const Part& o : parts)
                if (&o != &part) others *= at_least(0, 1 - o.power / x);
            slope += w * others * (part.power / x);
            add_change(part.gap, part.overlap, -w * others);
        }
        const P share = 1 - w + w * left;
        add_change(gap, g, slope);
        if (value_of(deepest_) < value_of(g)) deepest_ = g;
        if (!(value_of(share) > 0)) return;
        sum_ = fma(share, x, sum_);
        touch_[count_++] = {gap, g, share};
    }
    void add_change(const BoxGap& gap, const P& g, const P& slope) {
        if (value_of(slope) != 0) change_.add(gap, one_.centre, two_.centre, slope * (g * g * g));
    }

    const PlacedBox &one_, &two_;
    const double reach_;
    std::array<Vertex, 8> vertex_[2];
    std::size_t vertices_[2] = {0, 0};
    std::array<Touch, 2 * 8 + 12 * 12> touch_;
    std::size_t count_ = 0;
    P sum_ = 0.0, overlap_ = 0.0, deepest_ = 0.0;
    Wrench change_;
};
using BoxMeeting = MeetingOfBoxes<double>;

} // namespace skein
