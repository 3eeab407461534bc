// A rigid body made ready: mass, centre and principal axes of its parts, and its surface in these axes. Parts that
// overlap count twice. theory.md (59)-(59b)
//
//   m = sum m_p,  x_c = sum m_p x_p/m,  J = sum [J_p + m_p (|d|^2 1 - d d^T)],  d = x_p - x_c
//   sphere    m = 4/3 pi rho r^3,  J = 2/5 m r^2 1
//   capsule   m_c = pi rho r^2 l,  m_b = 4/3 pi rho r^3:  J_3 = m_c r^2/2 + 2 m_b r^2/5,
//             J_1 = J_2 = m_c (l^2/12 + r^2/4) + m_b (2 r^2/5 + l^2/4 + 3 l r/8)
//   box       |x_i| <= h_i and all within r of it:
//             V = 8 h1 h2 h3 + 8 r (h1 h2 + h2 h3 + h3 h1) + 2 pi r^2 (h1 + h2 + h3) + 4/3 pi r^3,
//             J_1 = rho (I_2 + I_3), I_i the integral of x_i^2: of box, plates on its faces, quarters of cylinders,
//             corners
//
// d3 is the axis whose 1/J differs most from the two others, which are then nearly alike. The splitting of the free top
// has its least error there (mechanics/drift.hpp), and a symmetric top has its axis along d3. Principal axes of the
// parts stay d1, d2, d3 in cyclic order.
#pragma once

#include "skein/core/quaternion.hpp"
#include "skein/rod/rod_spec.hpp"

#include <vector>

namespace skein {

/// Surface and inertia of a body. Lengths are measured from the centre of mass, along the principal axes, m.
struct BodyShape {
    /// Capsule of the surface. Both ends of a sphere, and of a box, are its centre.
    struct Part {
        Vec3d from, to;
        double radius;
        Vec3d half{0, 0, 0};        ///< half sides of a box without the rounding, m
        Quaterniond axes = no_turn; ///< frame of a box
        bool box = false;
        /// Radius of a ball, or of a capsule, that holds the part, m.
        double cover() const { return radius + norm(half); }
    };
    /// Line of a drawing. `slot` is the exposed slot (RodGroup) whose force its first end shows, or -1.
    struct Line {
        Vec3d from, to;
        double radius;
        int slot;
    };
    /// Ball that may touch walls.
    struct Point {
        Vec3d place;
        double radius;
    };
    double mass = 0, volume = 0; ///< kg, m^3
    Vec3d centre{0, 0, 0};       ///< centre of mass, in the frame of the parts, m
    Quaterniond axes = no_turn;  ///< principal axes, as a frame in the frame of the parts
    Vec3d inertia{0, 0, 0};      ///< kg m^2
    std::vector<Part> part;
    std::vector<Point> point;
    std::vector<Line> line;
    double reach = 0; ///< distance of the furthest point of the surface from the centre, m

    /// Throws InputError where no body can have this mass or inertia.
    explicit BodyShape(const RodSpec& spec);

    bool has_boxes() const;

    /// Cylinder about d3 of the parts' frame, through its origin, that holds the body.
    struct Column {
        double lowest, highest; ///< ends along d3, m
        double radius;          ///< m
    };
    Column column() const;

private:
    void take_axes(const Vec3d& values, const Mat3d& rows);
    void add_surface();
    void add_corners_and_edges(const Part& box, int slot);
};

} // namespace skein
