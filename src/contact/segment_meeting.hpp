// A segment and a rounded box: features that are near each other, and the share of the energy of each. theory.md (59e)
//   features   nodes of the segment with the box; edges and vertices of the box with the segment between its nodes
//   overlap    g = r1 + r2 - d of each; x = phi(g), energy of the normal spring over its stiffness
//   node       T = a x                         a = 1/2 where two elements have the node, else 1
//   edge       T = x product(1 - x_j/x)        j: nodes with the edge, vertices of the edge with the segment
//   vertex     T = x product(1 - x_j/x)        j: nodes with the vertex
//   all        E = k sum T
// An edge or a vertex whose nearest point is a node has no share: the node has it all. A rod that passes an edge hands
// its contact from element to node to element, and the sum stays. Forces are the gradient of E.
// A segment that has come into the sharp box has the middle of its part inside in place of edges there:
//   middle     T = x product(1 - x_j/x)        j: nodes with the box
// All is in the box's axes, from its centre. Cost: some 100 flop where they are apart, 500 to 2000 in touch.
#pragma once

#include "contact/box_distance.hpp"
#include "contact/contact_law.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace skein {

/// A segment between two nodes, in the axes of a box.
template <class P> struct SegmentAtBox {
    Vec3<P> from, along; ///< m
    double shares[2];    ///< of either node that belong to this element
};

/// Over doubles, or over numbers with their slopes.
template <class P> class MeetingOfSegment {
public:
    struct Gap {
        P s;                      ///< share of the segment
        Vec3<P> on_box, outwards; ///< nearest point of the feature, m; unit vector from there to the segment
        P distance;               ///< m
    };
    struct Touch {
        Gap gap;
        P overlap, share; ///< g, m; T/x
    };
    /// Forces on both nodes, and force and couple on the box about its centre.
    struct Load {
        Vec3<P> first = constant<P>({0, 0, 0}), second = first, couple = first;

        void add(const Gap& gap, const P& pressure) {
            const Vec3<P> force = pressure * gap.outwards;
            first += (1 - gap.s) * force;
            second += gap.s * force;
            couple -= cross(gap.on_box, force);
        }
    };

    MeetingOfSegment(const SegmentAtBox<P>& segment, const Vec3d& half, double reach, ContactNormal normal)
        : from_(segment.from), along_(segment.along), half_(half), squared_(dot(along_, along_)), reach_(reach),
          normal_(normal) {
        if (is_apart()) return;
        const bool ball = !(value_of(squared_) > 0);
        for (int end = 0; end < (ball ? 1 : 2); ++end) add_node(end, ball ? 1.0 : segment.shares[end]);
        if (ball) return;
        for (int axis = 0; axis < 3; ++axis) add_edges(axis);
        add_vertices();
        add_middle();
    }

    std::span<const Touch> touches() const { return {touch_.data(), count_}; }
    const P& energy() const { return energy_; }   ///< E/k
    const P& deepest() const { return deepest_; } ///< the largest g, m; 0 where nothing touches
    /// Forces as shares change, over k.
    const Load& change() const { return change_; }

    /// Energy and force of the normal spring (54) over its stiffness.
    static P energy_of(ContactNormal normal, const P& g) {
        return normal == ContactNormal::hertz ? 0.4 * (g * g) * sqrt(g) : 0.5 * (g * g);
    }
    static P force_of(ContactNormal normal, const P& g) { return normal == ContactNormal::hertz ? g * sqrt(g) : g; }

private:
    /// A feature that belongs to another one.
    struct Part {
        Gap gap;
        P overlap, energy;
    };
    struct Parts {
        std::array<Part, 4> part;
        std::size_t count = 0;
    };

    template <class T> static const T& at(const Vec3<T>& v, int axis) {
        return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
    }
    static Vec3<P> with(Vec3<P> v, int axis, const P& value) {
        (axis == 0 ? v.x : axis == 1 ? v.y : v.z) = value;
        return v;
    }
    Vec3<P> place(const P& s) const { return fma(s, along_, from_); }

    /// A face's plane is between both.
    bool is_apart() const {
        const Vec3d from = values_of(from_), to = values_of(from_ + along_);
        for (int i = 0; i < 3; ++i) {
            const double u = at(from, i), v = at(to, i), out = at(half_, i) + reach_;
            if (std::min(u, v) >= out || std::max(u, v) <= -out) return true;
        }
        return false;
    }
    /// True within the sharp box and on its surface.
    bool is_inside(const Vec3<P>& place) const {
        const Vec3d x = values_of(place);
        return std::abs(x.x) <= half_.x && std::abs(x.y) <= half_.y && std::abs(x.z) <= half_.z;
    }
    Gap between(const P& s, const Vec3<P>& on_box) const {
        const Vec3<P> apart = place(s) - on_box;
        const P distance = norm(apart);
        return {s, on_box, (1 / at_least(1e-150, distance)) * apart, distance};
    }
    Gap from_surface(const P& s) const {
        const PointAtBox<P> point = nearest_on_box(place(s), half_);
        return {s, point.on_box, point.outwards, point.distance};
    }
    static P at_least(double low, const P& x) { return low < value_of(x) ? x : P(low); }
    static P larger(const P& a, const P& b) { return value_of(a) < value_of(b) ? b : a; }
    P energy_of(const P& g) const { return energy_of(normal_, g); }
    P force_of(const P& g) const { return force_of(normal_, g); }

    void take(const Gap& gap, const P& g, const P& x, const P& share) {
        if (value_of(deepest_) < value_of(g)) deepest_ = g;
        if (!(value_of(share) > 0)) return;
        energy_ = fma(share, x, energy_);
        touch_[count_++] = {gap, g, share};
    }
    void append(Parts& parts, const Gap& gap) const {
        if (const P g = reach_ - gap.distance; value_of(g) > 0) parts.part[parts.count++] = {gap, g, energy_of(g)};
    }
    /// Adds T = x product(1 - x_j/x), and the forces of its change by derivatives of the product.
    void add(const Gap& gap, const P& g, const Parts& all) {
        const P x = energy_of(g);
        const std::span<const Part> parts(all.part.data(), all.count);
        P share = 1.0, slope = 0.0;
        for (const Part& part : parts) share *= at_least(0, 1 - part.energy / x);
        if (value_of(share) > 0)
            for (const Part& part : parts) {
                P others = 1.0;
                for (const Part& o : parts)
                    if (&o != &part) others *= 1 - o.energy / x;
                slope = fma(others, part.energy / x, slope);
                change_.add(part.gap, -others * force_of(part.overlap));
            }
        change_.add(gap, slope * force_of(g));
        take(gap, g, x, share);
    }

    void add_node(int end, double share) {
        const Gap gap = from_surface(P(end));
        if (const P g = reach_ - gap.distance; value_of(g) > 0) take(gap, g, energy_of(g), P(share));
    }

    void add_edges(int axis) {
        if (at(half_, axis) == 0) return;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const P du = at(along_, u), dv = at(along_, v), squared = fma(du, du, dv * dv);
        if (!(value_of(squared) > 1e-14 * value_of(squared_))) return; // parallel ones are nearest at an end
        for (int bits = 0; bits < 4; ++bits) {
            if ((bits & 1 && at(half_, u) == 0) || (bits & 2 && at(half_, v) == 0)) continue;
            const double eu = bits & 1 ? at(half_, u) : -at(half_, u), ev = bits & 2 ? at(half_, v) : -at(half_, v);
            const P s = fma(eu - at(from_, u), du, (ev - at(from_, v)) * dv) / squared;
            if (!(value_of(s) > 0 && value_of(s) < 1)) continue;
            const Vec3<P> here = place(s);
            const P along = at(here, axis);
            const double half = at(half_, axis);
            if (!(std::abs(value_of(along)) < half) || is_inside(here)) continue;
            const auto on_edge = [&](const P& w) { return with(with(with(Vec3<P>{}, axis, w), u, P(eu)), v, P(ev)); };
            const Gap gap = between(s, on_edge(along));
            const P g = reach_ - gap.distance;
            if (!(value_of(g) > 0)) continue;
            Parts parts;
            for (const int end : {0, 1})
                append(parts, between(P(end), on_edge(clamped(at(place(P(end)), axis), -half, half))));
            for (const double end : {-half, half}) append(parts, to_vertex(on_edge(P(end))));
            add(gap, g, parts);
        }
    }
    Gap to_vertex(const Vec3<P>& vertex) const {
        return between(clamped(P(dot(vertex - from_, along_) / squared_), 0, 1), vertex);
    }

    void add_vertices() {
        for (unsigned bits = 0; bits < 8; ++bits) {
            if (repeats_vertex(half_, bits)) continue;
            const Gap gap = to_vertex(constant<P>(box_vertex(half_, bits)));
            const P g = reach_ - gap.distance;
            if (!(value_of(g) > 0 && value_of(gap.s) > 0 && value_of(gap.s) < 1) || is_inside(place(gap.s))) continue;
            Parts parts;
            for (const int end : {0, 1}) append(parts, between(P(end), gap.on_box));
            add(gap, g, parts);
        }
    }

    void add_middle() {
        P enter = 0.0, leave = 1.0;
        for (int i = 0; i < 3; ++i) {
            const P p = at(from_, i), d = at(along_, i);
            const double h = at(half_, i);
            if (value_of(d) == 0) {
                if (!(std::abs(value_of(p)) < h)) return;
                continue;
            }
            const P one = (-h - p) / d, two = (h - p) / d;
            const bool in_order = value_of(one) < value_of(two);
            enter = larger(enter, in_order ? one : two);
            leave = -larger(-leave, -(in_order ? two : one));
        }
        if (!(value_of(enter) < value_of(leave))) return;
        const Gap gap = from_surface(0.5 * (enter + leave));
        Parts parts;
        for (const int end : {0, 1}) append(parts, from_surface(P(end)));
        add(gap, P(reach_ - gap.distance), parts);
    }

    const Vec3<P> from_, along_;
    const Vec3d half_;
    const P squared_;
    const double reach_;
    const ContactNormal normal_;
    std::array<Touch, 2 + 12 + 8 + 1> touch_;
    std::size_t count_ = 0;
    P energy_ = 0.0, deepest_ = 0.0;
    Load change_;
};

using SegmentMeeting = MeetingOfSegment<double>;

} // namespace skein
