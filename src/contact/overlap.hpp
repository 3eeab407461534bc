// How much of an element lies beside a near-parallel other: the weight of their contact where joints end it.       theory.md (56e)
//   on the line of one element: the feet f1 < f2 of the other's ends;  the overlap from max(0, f1) to min(1, f2), over min(1, f2 -
//   f1)
// Where it is between two free ends, of bodies that go on beyond, this is smoothed from 1 of a contact end by end: 1 - x^2 + x^3.
// Without joints it is 1. So it has no jump, and no kink but where those of neighbours make up for it.
#pragma once

#include "neighbourhood/exposure.hpp"

#include <algorithm>

namespace skein {

struct Overlap {
    double share;
    int end[2];                         ///< of the other, whose feet are the lower and the higher one
    double foot[2], change[2] = {0, 0}; ///< change: of the share as that foot moves
};

/// `joints`, `joints_of_other`: bits of Joint.
inline Overlap overlap_on(const Vec3d& start, const Vec3d& edge, const Vec3d& other, const Vec3d& edge_of_other, unsigned joints,
                          unsigned joints_of_other) {
    const bool same_way = dot(edge, edge_of_other) > 0;
    Overlap o{.share = 1, .end = {same_way ? 0 : 1, same_way ? 1 : 0}, .foot = {}};
    for (const int i : {0, 1}) o.foot[i] = dot(other + o.end[i] * edge_of_other - start, edge) / dot(edge, edge);
    if ((joints | joints_of_other) == 0) return o;
    const bool by_foot[2] = {o.foot[0] > 0, o.foot[1] < 1};
    bool at_joint = false;
    for (const int i : {0, 1}) at_joint |= (by_foot[i] ? joints_of_other >> o.end[i] : joints >> i) & 1;
    const double span = o.foot[1] - o.foot[0], shorter = std::min(1.0, span),
                 x = std::max(0.0, (std::min(1.0, o.foot[1]) - std::max(0.0, o.foot[0])) / shorter);
    o.share = at_joint ? x : 1 - x * x * (1 - x);
    if (x == 0) return o;
    const double slope = (at_joint ? 1 : x * (3 * x - 2)) / shorter, by_span = span < 1 ? x : 0;
    o.change[0] = slope * (by_span - by_foot[0]), o.change[1] = slope * (by_foot[1] - by_span);
    return o;
}

} // namespace skein
