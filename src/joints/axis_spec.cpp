#include "joints/axis_spec.hpp"

#include "formula/scope.hpp"
#include "formula/vector_of_time.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

void Motor::use(const FormulaScope& names, bool turns) {
    if (kind == MotorKind::none) return;
    const char* const unit = kind == MotorKind::position ? (turns ? "rad" : "m")
                             : kind == MotorKind::rate   ? (turns ? "rad/s" : "m/s")
                                                         : (turns ? "N m" : "N");
    formula = std::make_shared<VectorOfTime>(names, values.empty() ? std::vector<std::string>{value, "0", "0"} : values,
                                             unit, true);
    if (!by_rod()) take_largest(names.duration, 0); // else rods that have the motor decide
}

bool Motor::take_largest(double duration, double rod) {
    if (!formula) return true;
    constexpr int times = 64;
    bool finite = true;
    for (int n = 0; n <= times; ++n) {
        const MotorsNow<double> now = vector_at(duration * n / times, rod);
        const double size = std::abs(now.value.x);
        if (std::isfinite(size)) largest = std::max(largest, size);
        finite = finite && std::isfinite(size + now.value.y + now.value.z + norm(now.rate));
    }
    return finite;
}

const FormulaProgram* Motor::by_rod() const { return formula ? formula->by_rod() : nullptr; }

const std::vector<FormulaFault>& Motor::faults() const {
    static const std::vector<FormulaFault> none;
    return formula ? formula->faults() : none;
}

MotorNow<double> Motor::at(double time, double rod) const {
    const VectorOfTime::Point now = (*formula)(time, rod);
    return {now.value.x, now.rate.x};
}

MotorsNow<double> Motor::vector_at(double time, double rod) const {
    const VectorOfTime::Point now = (*formula)(time, rod);
    return {now.value, now.rate};
}

void Motor::fields(FieldVisitor& f) {
    f.choice({.name = "kind",
              .unit = "",
              .text = "position: a spring and a dashpot pull the axis to `value`; rate: a dashpot drives it at this "
                      "rate; force: this force or couple acts"},
             kind, motor_names);
    f.visit({.name = "value",
             .unit = "rad, m, rad/s, m/s, N m or N",
             .text = "formula of `t` and `rod`, the number of the first side's rod in its group: angle [rad] or "
                     "displacement [m] from the start, rate, or couple [N m] or force [N]; a program can drive the "
                     "tables in it"},
            value);
    f.visit({.name = "values",
             .unit = "rad, rad/s or N m",
             .text =
                 "spherical, instead of `value`: three formulas of the rotation vector from the start, of the rate of "
                 "turning, or of the couple; components in the axes of the assembly at the start, which the first "
                 "side carries"},
            values);
    f.visit({.name = "stiffness", .unit = "N m/rad or N/m", .text = "position: stiffness of the spring", .at_least = 0},
            stiffness);
    f.visit({.name = "damping",
             .unit = "N m s/rad or N s/m",
             .text = "position, rate: damping of the dashpot",
             .at_least = 0},
            damping);
    f.visit({.name = "most", .unit = "N m or N", .text = "largest couple or force; 0: no limit", .at_least = 0}, most);
}

double AxisSpec::reach() const {
    if (limits.size() == 2) return std::max(std::abs(limits[0]), std::abs(limits[1]));
    return motor.kind == MotorKind::position ? 1.5 * motor.largest : 0;
}

double AxisSpec::stiffness_bound() const {
    return spring + (limits.empty() ? 0 : stop_stiffness) + friction_stiffness + motor.stiffness;
}
double AxisSpec::drag_bound() const {
    return damping + (limits.empty() ? 0 : stop_damping) + friction_damping + motor.damping;
}

void AxisSpec::fields(FieldVisitor& f) {
    f.visit({.name = "spring",
             .unit = "N m/rad or N/m",
             .text =
                 "free axis: stiffness of a spring along it; its coordinate is 0 at the start; spherical: towards the "
                 "attitude at the start",
             .at_least = 0},
            spring);
    f.visit({.name = "spring_rest",
             .unit = "rad or m",
             .text = "free axis: coordinate at which the spring is free of force"},
            spring_rest);
    f.visit({.name = "axis_damping",
             .unit = "N m s/rad or N s/m",
             .text = "free axis: damping of a dashpot along it",
             .at_least = 0},
            damping);
    f.visit({.name = "limits",
             .unit = "rad or m",
             .text = "free axis: smallest and largest coordinate; angles count whole turns; spherical: limits of the "
                     "twist about `axis`, between -3 and 3 rad"},
            limits);
    f.visit({.name = "stop_stiffness",
             .unit = "N m/rad or N/m",
             .text = "stiffness of the stops at `limits` and at `cone`",
             .at_least = 0},
            stop_stiffness);
    f.visit({.name = "stop_damping",
             .unit = "N m s/rad or N s/m",
             .text = "damping of the stops, which never pull",
             .at_least = 0},
            stop_damping);
    f.visit({.name = "friction",
             .unit = "N m or N",
             .text =
                 "free axis: largest couple or force of dry friction, which holds the axis at rest; spherical: in all "
                 "directions",
             .at_least = 0},
            friction);
    f.visit({.name = "friction_stiffness",
             .unit = "N m/rad or N/m",
             .text = "stiffness of the spring by which friction holds",
             .at_least = 0},
            friction_stiffness);
    f.visit({.name = "friction_damping",
             .unit = "N m s/rad or N s/m",
             .text = "damping of the dashpot parallel to that spring, while friction holds",
             .at_least = 0},
            friction_damping);
    f.table({.name = "motor"}, motor);
}

} // namespace skein
