// Nearest points of a segment and a box in the box's own axes.                                     theory.md (59d)
//   x(s) = p + s d, s in [0, 1];  box |x_i| <= h_i;  c_i(s) = x_i - clamp(x_i, -h_i, h_i)
// |c|^2 is convex, and quadratic between the s at which the segment crosses a face's plane. Its slope d.c rises. It is
// 0 at the nearest point, or all along an interval, of which the middle is taken. Beside a face or an edge the same
// components of c differ from 0. The sine is that of the angle to this face or edge. Within the box the shortest way
// leads out. The result is exact but for round-off; cost: some 100 flop.
#pragma once

#include "skein/core/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

/// From the box's surface to a point.
struct BoxPoint {
    Vec3d on_box, outwards; ///< nearest point, and a unit vector
    double distance;        ///< below 0 within
};

inline BoxPoint nearest_on_box(const Vec3d& x, const Vec3d& half) {
    const double at[3] = {x.x, x.y, x.z}, h[3] = {half.x, half.y, half.z};
    double on[3];
    for (int i = 0; i < 3; ++i) on[i] = std::clamp(at[i], -h[i], h[i]);
    const Vec3d foot{on[0], on[1], on[2]}, apart = x - foot;
    if (const double distance = norm(apart); distance > 1e-150) return {foot, (1 / distance) * apart, distance};
    int least = 0;
    for (int i = 1; i < 3; ++i)
        if (h[i] - std::abs(at[i]) < h[least] - std::abs(at[least])) least = i;
    double normal[3] = {0, 0, 0};
    normal[least] = std::copysign(1.0, at[least]);
    on[least] = normal[least] * h[least];
    return {{on[0], on[1], on[2]}, {normal[0], normal[1], normal[2]}, std::abs(at[least]) - h[least]};
}

struct SegmentToBox {
    double s;
    double first, last;  ///< the s between which the segment lies beside the same face or edge
    double sine_squared; ///< 1 where there is none
};

inline SegmentToBox nearest_to_box(const Vec3d& p, const Vec3d& d, const Vec3d& half) {
    const double from[3] = {p.x, p.y, p.z}, along[3] = {d.x, d.y, d.z}, h[3] = {half.x, half.y, half.z};
    const double squared = dot(d, d);
    if (!(squared > 0)) return {0, 0, 0, 1};
    double at[8] = {0, 1};
    int ends = 2;
    for (int i = 0; i < 3; ++i)
        for (const double face : {-h[i], h[i]})
            if (along[i] != 0)
                if (const double s = (face - from[i]) / along[i]; s > 0 && s < 1) at[ends++] = s;
    std::sort(at, at + ends);
    const auto beyond = [&](int i, double s) {
        const double x = fma(s, along[i], from[i]);
        return x - std::clamp(x, -h[i], h[i]);
    };
    struct Slope {
        double value, round_off;
    };
    const auto slope = [&](double s) -> Slope {
        const Vec3d c{beyond(0, s), beyond(1, s), beyond(2, s)};
        return {dot(d, c), 1e-7 * norm(c) * std::sqrt(squared)};
    };
    // The interval in which the slope is 0.
    double low = 1, high = 0;
    for (int i = 0; i + 1 < ends; ++i) {
        const auto u = slope(at[i]), v = slope(at[i + 1]);
        if (v.value < -v.round_off) continue;
        low = u.value >= -u.round_off ? at[i] : at[i] + (at[i + 1] - at[i]) * (u.value / (u.value - v.value));
        break;
    }
    for (int i = ends - 1; i > 0; --i) {
        const auto u = slope(at[i - 1]), v = slope(at[i]);
        if (u.value > u.round_off) continue;
        high = v.value <= v.round_off ? at[i] : at[i] - (at[i] - at[i - 1]) * (v.value / (v.value - u.value));
        break;
    }
    SegmentToBox near{0.5 * (low + high), 0, 0, 1};
    for (int i = 0; i + 1 < ends; ++i) {
        if (!(at[i] <= near.s && near.s <= at[i + 1] && at[i] < at[i + 1])) continue;
        const double middle = 0.5 * (at[i] + at[i + 1]);
        double steep = 0;
        int faces = 0;
        for (int k = 0; k < 3; ++k)
            if (beyond(k, middle) != 0) {
                steep += along[k] * along[k];
                ++faces;
            }
        if (const double sine = steep / squared; faces > 0 && sine < near.sine_squared)
            near = {near.s, at[i], at[i + 1], sine};
    }
    return near;
}

} // namespace skein
