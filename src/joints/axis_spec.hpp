// Keys of a joint about a free axis: the angle of a hinge or of one axis of a universal joint, the way of a slider, the
// length of a distance, the turn of a spherical joint. All count from 0 at the start. A force is a couple for angles, N
// m; stiffnesses are N m/rad then.
#pragma once

#include "skein/core/fields.hpp"
#include "skein/core/vec3.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

class VectorOfTime;
struct FormulaScope;
struct FormulaFault;
struct FormulaProgram;

enum class MotorKind { none, position, rate, force };
inline constexpr std::string_view motor_names[] = {"none", "position", "rate", "force"};

/// Motor at a time, of a joint or of W joints side by side.
template <class P> struct MotorNow { P value, rate; };
/// Motors of a joint at a time: x and y of both axes of a universal joint, x of other free axes; of a spherical joint
/// the vector, along its own directions, and the rate of turning that goes with it.
template <class P> struct MotorsNow {
    Vec3<P> value{P(0.0), P(0.0), P(0.0)}, rate{P(0.0), P(0.0), P(0.0)};
    P cosine{1.0}, sine{0.0}; ///< of half the first value, of joints that turn

    MotorNow<P> first() const { return {value.x, rate.x}; }
    MotorNow<P> second() const { return {value.y, rate.y}; }
};

/// Drives the free axis.                                                                        theory.md (73h)
struct Motor {
    MotorKind kind = MotorKind::none;
    std::string value;               ///< formula of t and rod: position, rate or force
    std::vector<std::string> values; ///< of a spherical joint: rotation vector, rate or couple
    double stiffness = 0;            ///< position: force over the distance from it
    double damping = 0;              ///< position, rate: force over the difference of rates
    double most = 0;                 ///< largest force; 0: without limit

    std::shared_ptr<const VectorOfTime> formula; ///< as read by `use`
    double largest = 0;                          ///< of the value, at times of the run

    /// Reads the formulas, which may hold these names, in the unit of `kind` for an angle or a way.
    void use(const FormulaScope& names, bool turns);
    const std::vector<FormulaFault>& faults() const;
    /// Null where all joints have the same motor.
    const FormulaProgram* by_rod() const;
    MotorNow<double> at(double time, double rod) const;
    /// Motor of a spherical joint at a time, in the axes of the assembly.
    MotorsNow<double> vector_at(double time, double rod) const;
    /// Takes the values of a rod at times of a run into `largest`. False where one is not finite.
    bool take_largest(double duration, double rod);
    void fields(FieldVisitor& f);
};

struct AxisSpec {
    double spring = 0, spring_rest = 0;
    double damping = 0;
    std::vector<double> limits; ///< least and largest; none: no stops
    double stop_stiffness = 0, stop_damping = 0;
    double friction = 0; ///< largest force of dry friction
    double friction_stiffness = 0, friction_damping = 0;
    Motor motor;

    /// True where the free axis is not just free.
    bool any() const {
        return spring > 0 || damping > 0 || !limits.empty() || friction > 0 || motor.kind != MotorKind::none;
    }
    /// Largest stiffness and drag of all of them together.
    double stiffness_bound() const;
    double drag_bound() const;
    /// How far from 0 stops and the motor let the axis go; 0: they do not say.
    double reach() const;
    void fields(FieldVisitor& f);
};

} // namespace skein
