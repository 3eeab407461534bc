// Plain values of numbers that carry their slopes, by which templates over both choose.
#pragma once

#include "skein/core/dual_pack.hpp"
#include "skein/core/vec3.hpp"

namespace skein {

inline double value_of(double a) { return a; }
inline double value_of(const Pack<dual>& a) { return a.v; }
template <class T> Vec3d values_of(const Vec3<T>& a) { return {value_of(a.x), value_of(a.y), value_of(a.z)}; }

/// A value as it is, or one that does not change.
template <class T> Vec3<T> constant(const Vec3d& a) { return {T(a.x), T(a.y), T(a.z)}; }

} // namespace skein
