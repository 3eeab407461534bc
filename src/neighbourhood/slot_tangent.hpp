// Slopes of contact forces by the motion of one body alone, for implicit steps.                          theory.md
// (123)
//   a contact at the share s of an element, at the arm r n from its axis, moves by  u = (1-s) x[k] + s x[k+1] + r t x n
//   it resists with the stiffness  C = p n n^T + q (1 - n n^T):   u^T C u is, with w = (1 - s, s) and b_i = w_i q r n,
//     w_i w_j x_i^T C x_j      between nodes
//     -w_i q r x_i.(n x t)     node and turn:  x_i^T [-b_i] t
//     q r^2 t^T (1 - n n^T) t  the turn's own
// Sums over contacts keep this form: four lines of eight numbers for an element.
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/pack.hpp"

namespace skein {

/// Sums over the contacts of an element. Symmetric matrices stand as xx xy xz yy yz zz; lab, N/m, N, N m.
struct alignas(64) SlotTangent {
    double first[8];  ///< first node; then b_1 x, y
    double across[8]; ///< first node and second; then b_1 z
    double second[8]; ///< second node; then b_2 x, y
    double turn[8];   ///< turn of the element; then b_2 z
};
static_assert(sizeof(SlotTangent) == 256);

/// Contact of an element: n, p, q, share, arm, and stiffness against any turn of the element, N m.
struct alignas(64) PointTangent {
    double number[8]; ///< n x, y, z; p; q; s; r; the last

    bool acts() const { return number[3] != 0 || number[4] != 0; }
};

/// Adds a contact.
inline void add(SlotTangent& to, const PointTangent& of) {
    const auto [x, y, z, p, q, s, r, against_turns] = of.number;
    const double n[6] = {x * x, x * y, x * z, y * y, y * z, z * z}, one[6] = {1, 0, 0, 1, 0, 1};
    const double w = 1 - s, ww = w * w, ws = w * s, ss = s * s, over = p - q, arm = q * r, turn = arm * r;
    for (int i = 0; i < 6; ++i) {
        const double c = over * n[i] + q * one[i];
        to.first[i] += ww * c;
        to.across[i] += ws * c;
        to.second[i] += ss * c;
        to.turn[i] += turn * (one[i] - n[i]) + against_turns * one[i];
    }
    to.first[6] += w * arm * x;
    to.first[7] += w * arm * y;
    to.across[6] += w * arm * z;
    to.second[6] += s * arm * x;
    to.second[7] += s * arm * y;
    to.turn[6] += s * arm * z;
}

} // namespace skein
