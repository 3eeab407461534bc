// Unit quaternions (w, v): a director frame Q in four numbers. theory.md (5)
//   Q a = a + 2 w (a x v) + 2 (a x v) x v,   R(u): w = cos(u/2), v = sin(u/2)/u u;   q and -q are the same frame
// Operators are those of the matrices: q * a is Q a (lab to body), and r * q the frame R Q.
#pragma once

#include "skein/core/vec3.hpp"

#include <cstring>

namespace skein {

template <class P> struct Quaternion {
    P w;
    Vec3<P> v;

    SKEIN_INLINE friend Vec3<P> operator*(const Quaternion& q, const Vec3<P>& a) {
        const Vec3<P> t = cross(a, q.v + q.v);
        return {fma(t.y, q.v.z, fnma(t.z, q.v.y, fma(q.w, t.x, a.x))),
                fma(t.z, q.v.x, fnma(t.x, q.v.z, fma(q.w, t.y, a.y))),
                fma(t.x, q.v.y, fnma(t.y, q.v.x, fma(q.w, t.z, a.z)))};
    }
    SKEIN_INLINE friend Quaternion operator*(const Quaternion& r, const Quaternion& q) {
        return {fnma(r.v.x, q.v.x, fnma(r.v.y, q.v.y, fnma(r.v.z, q.v.z, r.w * q.w))),
                {fma(r.w, q.v.x, fma(r.v.x, q.w, fma(r.v.z, q.v.y, -(r.v.y * q.v.z)))),
                 fma(r.w, q.v.y, fma(r.v.y, q.w, fma(r.v.x, q.v.z, -(r.v.z * q.v.x)))),
                 fma(r.w, q.v.z, fma(r.v.z, q.w, fma(r.v.y, q.v.x, -(r.v.x * q.v.y))))}};
    }
};

/// The opposite turn, of a unit quaternion.
template <class P> SKEIN_INLINE Quaternion<P> inverse(const Quaternion<P>& q) { return {q.w, -q.v}; }

/// Q^T a, from body to lab components.
template <class P> SKEIN_INLINE Vec3<P> transpose_times(const Quaternion<P>& q, const Vec3<P>& a) {
    const Vec3<P> t = cross(q.v + q.v, a);
    return {fma(q.v.y, t.z, fnma(q.v.z, t.y, fma(q.w, t.x, a.x))),
            fma(q.v.z, t.x, fnma(q.v.x, t.z, fma(q.w, t.y, a.y))),
            fma(q.v.x, t.y, fnma(q.v.y, t.x, fma(q.w, t.z, a.z)))};
}

/// Cosine of half the angle between two frames, up to its sign.
template <class P> SKEIN_INLINE P dot(const Quaternion<P>& a, const Quaternion<P>& b) {
    return fma(a.w, b.w, dot(a.v, b.v));
}

/// d3 in lab components, the third row of Q.
template <class P> SKEIN_INLINE Vec3<P> third_director(const Quaternion<P>& q) {
    const Vec3<P> twice = q.v + q.v;
    return {fma(q.v.x, twice.z, q.w * twice.y), fma(q.v.y, twice.z, -(q.w * twice.x)),
            fnma(q.v.x, twice.x, fnma(q.v.y, twice.y, P(1.0)))};
}

/// Matrix Q with rows d1, d2, d3.
template <class P> SKEIN_INLINE Mat3<P> matrix(const Quaternion<P>& q) {
    const Vec3<P> twice = q.v + q.v, turned = q.w * twice;
    const P xx = q.v.x * twice.x, yy = q.v.y * twice.y, zz = q.v.z * twice.z;
    return {{P(1.0) - (yy + zz), fma(q.v.x, twice.y, turned.z), fma(q.v.x, twice.z, -turned.y)},
            {fma(q.v.x, twice.y, -turned.z), P(1.0) - (xx + zz), fma(q.v.y, twice.z, turned.x)},
            {fma(q.v.x, twice.z, turned.y), fma(q.v.y, twice.z, -turned.x), P(1.0) - (xx + yy)}};
}

using Quaterniond = Quaternion<double>;
inline constexpr Quaterniond no_turn{1, {0, 0, 0}};
/// True where a and b agree to the bit.
inline bool same_bits(const Quaterniond& a, const Quaterniond& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Quaternion of a frame with orthonormal rows; w >= 0.
Quaterniond quaternion(const Mat3d& q);

template <int W> SKEIN_INLINE Quaternion<Pack<W>> broadcast(const Quaterniond& q) {
    return {Pack<W>(q.w), broadcast<W>(q.v)};
}
template <int W> SKEIN_INLINE Quaterniond lane(const Quaternion<Pack<W>>& q, int i) { return {q.w[i], lane(q.v, i)}; }
template <int W> SKEIN_INLINE void set_lane(Quaternion<Pack<W>>& q, int i, const Quaterniond& b) {
    q.w.set(i, b.w);
    set_lane(q.v, i, b.v);
}

template <int W>
SKEIN_INLINE Quaternion<Pack<W>> select(Mask<W> m, const Quaternion<Pack<W>>& a, const Quaternion<Pack<W>>& b) {
    return {select(m, a.w, b.w), select(m, a.v, b.v)};
}
template <int W> SKEIN_INLINE Quaternion<Pack<W>> from_lane_after(const Quaternion<Pack<W>>& a) {
    return {from_lane_after(a.w), from_lane_after(a.v)};
}

} // namespace skein
