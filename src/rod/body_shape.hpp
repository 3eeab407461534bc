// A rigid body made ready: mass, centre and principal axes of its parts, and its surface in these axes.     theory.md
// (59)-(59b) Parts that overlap count twice.
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
// d3 is the axis whose 1/J differs most from the others', which are nearly alike then; so that the free top is split
// where least is lost (mechanics/drift.hpp), and a symmetric top has its axis along d3. d1, d2, d3 are the axes of the
// parts where these are principal, but for their order, which is cyclic.
#pragma once

#include "skein/core/quaternion.hpp"
#include "skein/rod/rod_spec.hpp"

#include <vector>

namespace skein {

/// All lengths from the centre of mass, along the principal axes, m.
struct BodyShape {
    /// A capsule of the surface; a sphere has both ends at one place, a box its centre.
    struct Part {
        Vec3d from, to;
        double radius;
        Vec3d half{0, 0, 0};        ///< of a box: half of its sides without the rounding
        Quaterniond axes = no_turn; ///< of a box, as a frame
        bool box = false;
        /// Of a ball, or a capsule, that holds the part.
        double cover() const { return radius + norm(half); }
    };
    /// A line of a drawing; `slot`: the exposed one (RodGroup) whose force its first end shows, -1: none.
    struct Line {
        Vec3d from, to;
        double radius;
        int slot;
    };
    /// A ball that may touch walls.
    struct Point {
        Vec3d place;
        double radius;
    };
    double mass = 0, volume = 0; ///< kg, m^3
    Vec3d centre{0, 0, 0};       ///< of mass, in the frame of the parts
    Quaterniond axes = no_turn;  ///< principal axes, as a frame in that of the parts
    Vec3d inertia{0, 0, 0};      ///< kg m^2
    std::vector<Part> part;
    std::vector<Point> point;
    std::vector<Line> line;
    double reach = 0; ///< of the furthest point of the surface from the centre

    /// Throws InputError where mass or inertia are none that a body may have.
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
