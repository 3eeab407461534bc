// Prescribed motion of a held end: a table in time, a sinusoid, formulas, or a sum of them. theory.md (46)
//   u(t) = U(t) + A sin(2 pi t/T + phase) + F(t)   displacement of the end node, lab, m
//   r(t) = R(t) + B sin(2 pi t/T + phase) + G(t)   rotation vector of the wall about the node, lab, rad;
//                                                  the wall's frame is Q_w R(r)
// U and R go from entry to entry of their tables linearly, or smoothly (3 s^2 - 2 s^3), and stay at the last entry
// after it. F and G are formulas of t; their rates are derivatives of the formulas.
#pragma once

#include "skein/core/fields.hpp"

#include <memory>
#include <string>
#include <vector>

namespace skein {

class Objections;
class VectorOfTime;
struct FormulaScope;

struct EndMotion {
    std::vector<double> times;      ///< s, rising
    std::vector<Vec3d> translation; ///< m, one per time; empty: none
    std::vector<Vec3d> rotation;    ///< rad, one per time; empty: none
    bool smooth = false;
    Vec3d amplitude{0, 0, 0};          ///< A, m
    Vec3d rotation_amplitude{0, 0, 0}; ///< B, rad
    double period = 0;                 ///< T, s
    double phase = 0;                  ///< rad

    std::vector<std::string> translation_formula;             ///< F, three of t, m; empty: none
    std::vector<std::string> rotation_formula;                ///< G, three of t, rad; empty: none
    std::shared_ptr<const VectorOfTime> formula_u, formula_r; ///< formulas as read by `use`

    void fields(FieldVisitor& f);
    /// Reads the formulas, which may hold these names. Before this call they are 0.
    void use(const FormulaScope& names);
    /// Adds the faults of the formulas to the objections, whose table must be this one. `free`: 1 in the lab directions
    /// in which the end slides.
    void check_formulas(const Vec3d& free, Objections& objections) const;

    bool moves() const { return !translation.empty() || !translation_formula.empty() || oscillates(amplitude); }
    bool turns() const { return !rotation.empty() || !rotation_formula.empty() || oscillates(rotation_amplitude); }

    /// Value and rate at one time.
    struct Point {
        Vec3d value{0, 0, 0}, rate{0, 0, 0};
    };
    Point displacement(double time) const { return at(time, translation, amplitude, formula_u.get()); }
    Point turn(double time) const { return at(time, rotation, rotation_amplitude, formula_r.get()); }

private:
    bool oscillates(const Vec3d& a) const { return period != 0 && (a.x != 0 || a.y != 0 || a.z != 0); }
    Point at(double time, const std::vector<Vec3d>& table, const Vec3d& swing, const VectorOfTime* formula) const;
};

} // namespace skein
