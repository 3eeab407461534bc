// Three-vectors and 3x3 matrices over a value type P (double in set-up code, Pack<W> in kernels).
// A director frame Q as a matrix has rows d1, d2, d3 (lab components): body vector = Q * lab vector. Rods store
// quaternions.
#pragma once

#include "skein/core/pack.hpp"

#include <utility>

namespace skein {

/// a b + c, rounded once.
SKEIN_INLINE double fma(double a, double b, double c) { return detail::fma_of_one(a, b, c); }
SKEIN_INLINE double fnma(double a, double b, double c) { return detail::fma_of_one(-a, b, c); }
inline double sqrt(double a) { return __builtin_sqrt(a); }

template <class P> struct Vec3 {
    P x, y, z;

    SKEIN_INLINE Vec3& operator+=(const Vec3& b) {
        x = x + b.x;
        y = y + b.y;
        z = z + b.z;
        return *this;
    }
    SKEIN_INLINE Vec3& operator-=(const Vec3& b) {
        x = x - b.x;
        y = y - b.y;
        z = z - b.z;
        return *this;
    }
    SKEIN_INLINE friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    SKEIN_INLINE friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    SKEIN_INLINE friend Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
    SKEIN_INLINE friend Vec3 operator*(P s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
};

template <class P> SKEIN_INLINE P dot(const Vec3<P>& a, const Vec3<P>& b) {
    return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
}
template <class P> SKEIN_INLINE P norm(const Vec3<P>& a) { return sqrt(dot(a, a)); }
template <class P> SKEIN_INLINE Vec3<P> cross(const Vec3<P>& a, const Vec3<P>& b) {
    return {fma(a.y, b.z, -(a.z * b.y)), fma(a.z, b.x, -(a.x * b.z)), fma(a.x, b.y, -(a.y * b.x))};
}
/// s a + b
template <class P> SKEIN_INLINE Vec3<P> fma(P s, const Vec3<P>& a, const Vec3<P>& b) {
    return {fma(s, a.x, b.x), fma(s, a.y, b.y), fma(s, a.z, b.z)};
}
/// Component-wise product, e.g. a diagonal stiffness times a strain.
template <class P> SKEIN_INLINE Vec3<P> scale(const Vec3<P>& a, const Vec3<P>& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

template <class P> struct Mat3 {
    Vec3<P> d1, d2, d3; // rows

    SKEIN_INLINE friend Vec3<P> operator*(const Mat3& q, const Vec3<P>& a) {
        return {dot(q.d1, a), dot(q.d2, a), dot(q.d3, a)};
    }
};

/// Q^T a, from body to lab components.
template <class P> SKEIN_INLINE Vec3<P> transpose_times(const Mat3<P>& q, const Vec3<P>& a) {
    return fma(a.x, q.d1, fma(a.y, q.d2, a.z * q.d3));
}

using Vec3d = Vec3<double>;
using Mat3d = Mat3<double>;

inline bool zero(const Vec3d& v) { return v.x == 0 && v.y == 0 && v.z == 0; }
/// Vector of length 1 along a, which is not zero.
inline Vec3d unit(const Vec3d& a) { return (1 / norm(a)) * a; }
/// Directions u, v that make a right-handed basis u, v, axis with an `axis` of length 1.
inline std::pair<Vec3d, Vec3d> directions_across(const Vec3d& axis) {
    const Vec3d other = axis.x < 0.5 && axis.x > -0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    const Vec3d u = unit(cross(axis, other));
    return {u, cross(axis, u)};
}
inline bool parallel(const Vec3d& a, const Vec3d& b) { return norm(cross(a, b)) <= 1e-9 * norm(a) * norm(b); }

/// A scalar vector in every lane.
template <int W> SKEIN_INLINE Vec3<Pack<W>> broadcast(const Vec3d& a) {
    return {Pack<W>(a.x), Pack<W>(a.y), Pack<W>(a.z)};
}
/// Packs as they are, so that kernels need not know whether a constant varies from lane to lane.
template <int W> SKEIN_INLINE const Vec3<Pack<W>>& broadcast(const Vec3<Pack<W>>& a) { return a; }

template <int W> SKEIN_INLINE Vec3<Pack<W>> select(Mask<W> m, const Vec3<Pack<W>>& a, const Vec3<Pack<W>>& b) {
    return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
template <int W> SKEIN_INLINE Vec3<Pack<W>> from_lane_before(const Vec3<Pack<W>>& a) {
    return {from_lane_before(a.x), from_lane_before(a.y), from_lane_before(a.z)};
}
template <int W> SKEIN_INLINE Vec3<Pack<W>> from_lane_after(const Vec3<Pack<W>>& a) {
    return {from_lane_after(a.x), from_lane_after(a.y), from_lane_after(a.z)};
}

template <int W> SKEIN_INLINE Vec3d lane(const Vec3<Pack<W>>& a, int i) { return {a.x[i], a.y[i], a.z[i]}; }
template <int W> SKEIN_INLINE void set_lane(Vec3<Pack<W>>& a, int i, const Vec3d& b) {
    a.x.set(i, b.x);
    a.y.set(i, b.y);
    a.z.set(i, b.z);
}

} // namespace skein
