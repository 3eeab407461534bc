// Bearings: elements held about one lab axis or two. The couple of a bearing acts along the axes that it holds, and
// does no work. theory.md (47c)
//   held about e      w <- w - G n (n.w)/(n.G n)
//   held but about e  w <- n (n.G^-1 w)/(n.G^-1 n)       n = Q e;  G: change of the rate by a unit impulse, body axes
#pragma once

#include "skein/rod/rod_group.hpp"

#include <vector>

namespace skein {

struct Bearing {
    int element;
    Vec3d axis;       ///< lab
    bool turns_about; ///< the element turns about the axis alone; false: about all directions across it
};

/// Bearings of a group. The published law has none: its elements are held as published codes hold them.
std::vector<Bearing> bearings_of(const RodGroup& group);

/// Rate of an element after the impulse of its bearing.
template <class P>
SKEIN_INLINE Vec3<P> rate_on(const Bearing& bearing, const Quaternion<P>& q, const Vec3<P>& w, const Vec3<P>& gain) {
    const Vec3<P> n = q * Vec3<P>{P(bearing.axis.x), P(bearing.axis.y), P(bearing.axis.z)};
    if (bearing.turns_about) {
        const Vec3<P> m{n.x / gain.x, n.y / gain.y, n.z / gain.z};
        return (dot(m, w) / dot(m, n)) * n;
    }
    const Vec3<P> by_impulse = scale(gain, n);
    return fma(-(dot(n, w) / dot(n, by_impulse)), by_impulse, w);
}

} // namespace skein
