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
struct SegmentAtBox {
    Vec3d from, along; ///< m
    double shares[2];  ///< of either node that belong to this element
};

class SegmentMeeting {
public:
    struct Gap {
        double s;               ///< share of the segment
        Vec3d on_box, outwards; ///< nearest point of the feature, m; unit vector from there to the segment
        double distance;        ///< m
    };
    struct Touch {
        Gap gap;
        double overlap, share; ///< g, m; T/x
    };
    /// Forces on both nodes, and force and couple on the box about its centre.
    struct Load {
        Vec3d first{0, 0, 0}, second{0, 0, 0}, couple{0, 0, 0};

        void add(const Gap& gap, double pressure) {
            const Vec3d force = pressure * gap.outwards;
            first += (1 - gap.s) * force;
            second += gap.s * force;
            couple -= cross(gap.on_box, force);
        }
    };

    SegmentMeeting(const SegmentAtBox& segment, const Vec3d& half, double reach, ContactNormal normal)
        : from_(segment.from), along_(segment.along), half_(half), squared_(dot(along_, along_)), reach_(reach),
          normal_(normal) {
        if (is_apart()) return;
        const bool ball = !(squared_ > 0);
        for (int end = 0; end < (ball ? 1 : 2); ++end) add_node(end, ball ? 1 : segment.shares[end]);
        if (ball) return;
        for (int axis = 0; axis < 3; ++axis) add_edges(axis);
        add_vertices();
        add_middle();
    }

    std::span<const Touch> touches() const { return {touch_.data(), count_}; }
    double energy() const { return energy_; }   ///< E/k
    double deepest() const { return deepest_; } ///< the largest g, m; 0 where nothing touches
    /// Forces as shares change, over k.
    const Load& change() const { return change_; }

    /// Energy and force of the normal spring (54) over its stiffness.
    static double energy_of(ContactNormal normal, double g) {
        return normal == ContactNormal::hertz ? 0.4 * (g * g) * sqrt(g) : 0.5 * (g * g);
    }
    static double force_of(ContactNormal normal, double g) { return normal == ContactNormal::hertz ? g * sqrt(g) : g; }

private:
    /// A feature that belongs to another one.
    struct Part {
        Gap gap;
        double overlap, energy;
    };
    struct Parts {
        std::array<Part, 4> part;
        std::size_t count = 0;
    };

    static double at(const Vec3d& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
    static Vec3d with(Vec3d v, int axis, double value) {
        (axis == 0 ? v.x : axis == 1 ? v.y : v.z) = value;
        return v;
    }
    Vec3d place(double s) const { return fma(s, along_, from_); }

    /// A face's plane is between both.
    bool is_apart() const {
        const Vec3d to = from_ + along_;
        for (int i = 0; i < 3; ++i) {
            const double u = at(from_, i), v = at(to, i), out = at(half_, i) + reach_;
            if (std::min(u, v) >= out || std::max(u, v) <= -out) return true;
        }
        return false;
    }
    /// True within the sharp box and on its surface.
    bool is_inside(const Vec3d& x) const {
        return std::abs(x.x) <= half_.x && std::abs(x.y) <= half_.y && std::abs(x.z) <= half_.z;
    }
    Gap between(double s, const Vec3d& on_box) const {
        const Vec3d apart = place(s) - on_box;
        const double distance = norm(apart);
        return {s, on_box, (1 / std::max(distance, 1e-150)) * apart, distance};
    }
    Gap from_surface(double s) const {
        const BoxPoint point = nearest_on_box(place(s), half_);
        return {s, point.on_box, point.outwards, point.distance};
    }
    double energy_of(double g) const { return energy_of(normal_, g); }
    double force_of(double g) const { return force_of(normal_, g); }

    void take(const Gap& gap, double g, double x, double share) {
        deepest_ = std::max(deepest_, g);
        if (!(share > 0)) return;
        energy_ = fma(share, x, energy_);
        touch_[count_++] = {gap, g, share};
    }
    void append(Parts& parts, const Gap& gap) const {
        if (const double g = reach_ - gap.distance; g > 0) parts.part[parts.count++] = {gap, g, energy_of(g)};
    }
    /// Adds T = x product(1 - x_j/x), and the forces of its change by derivatives of the product.
    void add(const Gap& gap, double g, const Parts& all) {
        const double x = energy_of(g);
        const std::span<const Part> parts(all.part.data(), all.count);
        double share = 1, slope = 0;
        for (const Part& part : parts) share *= std::max(0.0, 1 - part.energy / x);
        if (share > 0)
            for (const Part& part : parts) {
                double others = 1;
                for (const Part& o : parts)
                    if (&o != &part) others *= 1 - o.energy / x;
                slope = fma(others, part.energy / x, slope);
                change_.add(part.gap, -others * force_of(part.overlap));
            }
        change_.add(gap, slope * force_of(g));
        take(gap, g, x, share);
    }

    void add_node(int end, double share) {
        const Gap gap = from_surface(end);
        if (const double g = reach_ - gap.distance; g > 0) take(gap, g, energy_of(g), share);
    }

    void add_edges(int axis) {
        if (at(half_, axis) == 0) return;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const double du = at(along_, u), dv = at(along_, v), squared = fma(du, du, dv * dv);
        if (!(squared > 1e-14 * squared_)) return; // parallel ones are nearest at an end
        for (int bits = 0; bits < 4; ++bits) {
            if ((bits & 1 && at(half_, u) == 0) || (bits & 2 && at(half_, v) == 0)) continue;
            const double eu = bits & 1 ? at(half_, u) : -at(half_, u), ev = bits & 2 ? at(half_, v) : -at(half_, v);
            const double s = fma(eu - at(from_, u), du, (ev - at(from_, v)) * dv) / squared;
            if (!(s > 0 && s < 1)) continue;
            const Vec3d here = place(s);
            const double along = at(here, axis), half = at(half_, axis);
            if (!(std::abs(along) < half) || is_inside(here)) continue;
            const auto on_edge = [&](double w) { return with(with(with({0, 0, 0}, axis, w), u, eu), v, ev); };
            const Gap gap = between(s, on_edge(along));
            const double g = reach_ - gap.distance;
            if (!(g > 0)) continue;
            Parts parts;
            for (const int end : {0, 1})
                append(parts, between(end, on_edge(std::clamp(at(place(end), axis), -half, half))));
            for (const double end : {-half, half}) append(parts, to_vertex(on_edge(end)));
            add(gap, g, parts);
        }
    }
    Gap to_vertex(const Vec3d& vertex) const {
        return between(std::clamp(dot(vertex - from_, along_) / squared_, 0.0, 1.0), vertex);
    }

    void add_vertices() {
        for (unsigned bits = 0; bits < 8; ++bits) {
            if (repeats_vertex(half_, bits)) continue;
            const Gap gap = to_vertex(box_vertex(half_, bits));
            const double g = reach_ - gap.distance;
            if (!(g > 0 && gap.s > 0 && gap.s < 1) || is_inside(place(gap.s))) continue;
            Parts parts;
            for (const int end : {0, 1}) append(parts, between(end, gap.on_box));
            add(gap, g, parts);
        }
    }

    void add_middle() {
        double enter = 0, leave = 1;
        for (int i = 0; i < 3; ++i) {
            const double p = at(from_, i), d = at(along_, i), h = at(half_, i);
            if (d == 0) {
                if (!(std::abs(p) < h)) return;
                continue;
            }
            const double one = (-h - p) / d, two = (h - p) / d;
            enter = std::max(enter, std::min(one, two));
            leave = std::min(leave, std::max(one, two));
        }
        if (!(enter < leave)) return;
        const Gap gap = from_surface(0.5 * (enter + leave));
        Parts parts;
        for (const int end : {0, 1}) append(parts, from_surface(end));
        add(gap, reach_ - gap.distance, parts);
    }

    const Vec3d from_, along_, half_;
    const double squared_, reach_;
    const ContactNormal normal_;
    std::array<Touch, 2 + 12 + 8 + 1> touch_;
    std::size_t count_ = 0;
    double energy_ = 0, deepest_ = 0;
    Load change_;
};

} // namespace skein
