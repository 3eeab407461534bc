// Normal contact of two rods, as published. Elements i of A outside, j of B inside, and every pair acts at once, so
// that the next one reads what it left.
//   d    unit vector between the nearest points, from A to B;  g = r_i + r_j - distance
//   N    = |min((f_B - f_A).d, 0)|,  f = mean of an element's nodes of all forces so far: what presses the pair
//   together F    = (N + H(g)/2 (k g + nu (v_A - v_B).d)) d,  on B;  -F on A
// There is no friction.
#pragma once

#include "segments.hpp"

namespace skein::replay {

struct RodRodContact {
    double stiffness, damping; ///< k, N/m; nu, N s/m
    explicit RodRodContact(const Entry& entry);
    void add(Rod& a, Rod& b) const;
};

} // namespace skein::replay
