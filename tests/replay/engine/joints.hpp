// Joints of two rods, as published. A node or element of one rod and one of the other; -1 is the last.
//   point   F = k (x_j - x_i) + nu (v_j - v_i) on node i of A, -F on node j of B
//   hinge   T = k_t t x (-(t.n) n),  t: tangent of element j of B, n: what it is not to turn to
//   fixed   T = k_t Q_B^T phi - nu_t (w_B - w_A),  phi = log(C^T Q_A Q_B^T), C: Q_B^T Q_A at rest
//           -T on A and T on B, of the elements with the same numbers
//   sides   of elements i of A and j of B:  S = k (y_j - y_i),  y = centre + r,  r = Q^T d (radius + o/(2 sqrt e)),
//   gaps rounded to 1e-12 m
//           F = S + nu (v_j - v_i) on A by halves to its nodes, -F on B; couples r_i x S and r_j x (-S)
#pragma once

#include "rod.hpp"

namespace skein::replay {

class PointJoint {
public:
    PointJoint(const Entry& entry, const Rod& a, const Rod& b);
    void add(Rod& a, Rod& b) const;

private:
    enum class Turn { free, hinge, fixed };
    Turn turn_;
    double stiffness_, damping_;                             ///< N/m, N s/m
    double torsional_stiffness_ = 0, torsional_damping_ = 0; ///< N m/rad, N m s/rad
    Vec3d normal_{0, 0, 1};                                  ///< n
    Quaterniond rest_{1, {0, 0, 0}};                         ///< C^T
    std::size_t node_a_, node_b_, element_a_ = 0, element_b_ = 0;
};

class SideJoint {
public:
    SideJoint(const Entry& entry, const Rod& a, const Rod& b);
    void add(Rod& a, Rod& b) const;

private:
    struct Pair {
        std::size_t i, j;
        Vec3d direction_a, direction_b; ///< d, body
        double offset;                  ///< o, m
    };
    double stiffness_, damping_; ///< N/m, N s/m, of a pair
    std::vector<Pair> pairs_;
};

} // namespace skein::replay
