// Closed surface of triangles: signed distance, and the solid within it. theory.md (149), (150)
#pragma once

#include "rod/solids.hpp"
#include "skein/core/vec3.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Boxes around triangles, halved along their longest side.
class TriangleTree {
public:
    struct Box {
        Vec3d lower, upper;
    };
    TriangleTree() = default;
    explicit TriangleTree(std::span<const Box> of_triangles);

    /// Calls visit(triangle) for triangles whose boxes may hold a nearer point than `squared`, m^2, which visit
    /// returns. Nearer boxes come first.
    template <class Visit> void for_nearest(const Vec3d& place, double squared, Visit&& visit) const;
    /// Calls visit(triangle) for triangles whose boxes meet a box.
    template <class Visit> void for_meeting(const Box& box, Visit&& visit) const;

private:
    /// Leaves have triangles first to first + count, others a child behind them and another one at `first`.
    struct Node {
        Box box;
        std::uint32_t first, count;
    };
    static constexpr std::uint32_t most_in_leaf = 4;
    void build(std::span<const Box> of_triangles, std::uint32_t from, std::uint32_t to);

    std::vector<Node> nodes_;
    std::vector<std::uint32_t> triangle_;
};

class TriangleMesh {
public:
    using Triangle = std::array<std::uint32_t, 3>;
    /// Place of a triangle in its file, for messages.
    using Where = std::function<std::string(std::size_t triangle)>;

    /// Points, m, and triangles whose corners are counter-clockwise as seen from outside. Points in one place count as
    /// one, and triangles with two corners in one place are left out. Throws InputError where triangles leave the
    /// surface open, turn to the wrong side or go through each other.
    TriangleMesh(std::vector<Vec3d> points, std::vector<Triangle> triangles, const Where& where);

    /// Signed distance of a place, m, above 0 outside.
    double distance(const Vec3d& place) const;
    const Solid& solid() const { return solid_; }
    std::span<const Vec3d> points() const { return points_; }
    std::span<const Triangle> triangles() const { return triangles_; }
    /// Corners of the box along the axes that holds it, m.
    const Vec3d& lower() const { return lower_; }
    const Vec3d& upper() const { return upper_; }
    /// Distance of the furthest point from the origin, m.
    double reach() const;

private:
    /// Nearest point of a triangle, and whether it is within it, on an edge or a corner.
    struct Nearest {
        Vec3d at;
        double squared; ///< of its distance, m^2
        int part;       ///< 0: within; 1 to 3: edge from that corner on; 4 to 6: corner
    };
    struct Edge {
        std::uint32_t low, high;
        std::uint32_t triangle;
        std::uint8_t side; ///< of the triangle, from this corn on
        bool forward;      ///< from low to high
    };
    Vec3d corner(std::size_t triangle, int i) const {
        return points_[triangles_[triangle][static_cast<std::size_t>(i)]];
    }
    Nearest nearest(std::size_t triangle, const Vec3d& place) const;
    /// Normal (149) at that part of a triangle.
    Vec3d normal(std::size_t triangle, int part) const;
    TriangleTree::Box box_of(std::size_t triangle) const;

    void merge_points(const Where& where);
    std::vector<Edge> sorted_edges() const;
    void close(const Where& where);
    void find_normals();
    void refuse_crossings(const Where& where) const;
    void refuse_wrong_sides(const Where& where) const;
    void find_solid();

    std::vector<Vec3d> points_;
    std::vector<Triangle> triangles_;
    std::vector<std::size_t> given_;               ///< by triangle: its number in the file
    std::vector<std::array<std::uint32_t, 3>> to_; ///< by triangle and side: the triangle beyond it
    std::vector<Vec3d> normal_, at_point_;         ///< by triangle, of length 1; by point
    TriangleTree tree_;
    Solid solid_{};
    Vec3d lower_{0, 0, 0}, upper_{0, 0, 0};
};

} // namespace skein
