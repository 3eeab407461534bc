// Prescribed motion of a held end: a table in time, a sinusoid, or both.                      theory.md (46)
//   u(t) = U(t) + A sin(2 pi t/T + phase)   displacement of the end node, lab, m
//   r(t) = R(t) + B sin(2 pi t/T + phase)   rotation vector of the wall about the node, lab, rad; the wall's frame is Q_w R(r)
// U and R go from entry to entry of their tables linearly, or smoothly (3 s^2 - 2 s^3), and stay at the last entry after it.
#pragma once

#include "skein/core/fields.hpp"

#include <vector>

namespace skein {

struct EndMotion {
    std::vector<double> times;      ///< s, rising
    std::vector<Vec3d> translation; ///< m, one per time; empty: none
    std::vector<Vec3d> rotation;    ///< rad, one per time; empty: none
    bool smooth = false;
    Vec3d amplitude{0, 0, 0};          ///< A, m
    Vec3d rotation_amplitude{0, 0, 0}; ///< B, rad
    double period = 0;                 ///< T, s
    double phase = 0;                  ///< rad

    void fields(FieldVisitor& f);

    bool moves() const { return !translation.empty() || oscillates(amplitude); }
    bool turns() const { return !rotation.empty() || oscillates(rotation_amplitude); }

    /// At one time: value and rate.
    struct Point {
        Vec3d value{0, 0, 0}, rate{0, 0, 0};
    };
    Point displacement(double time) const { return at(time, translation, amplitude); }
    Point turn(double time) const { return at(time, rotation, rotation_amplitude); }

private:
    bool oscillates(const Vec3d& a) const { return period != 0 && (a.x != 0 || a.y != 0 || a.z != 0); }
    Point at(double time, const std::vector<Vec3d>& table, const Vec3d& swing) const;
};

} // namespace skein
