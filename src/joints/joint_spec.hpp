// Keys of a scene for joints: rods of an assembly that are joined, places and kinds.
#pragma once

#include "joints/axis_spec.hpp"
#include "skein/core/fields.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Kinds of joints. spherical: two points stay together. hinge: so do two directions. fixed: so do both frames.
/// side_by_side: the sides of elements that lie beside each other. tip_to_side: an end of a rod, its direction and the
/// side of another rod. universal: two points, and two directions at right angles. slider: both frames, and a point on
/// a line. distance: two points keep their distance. bushing: six springs and dashpots, along and about three axes.
enum class JointKind { spherical, hinge, fixed, side_by_side, tip_to_side, universal, slider, distance, bushing };
inline constexpr std::string_view joint_names[] = {"spherical", "hinge",  "fixed",    "side_by_side", "tip_to_side",
                                                   "universal", "slider", "distance", "bushing"};

/// Kinds with a direction of their own.
constexpr bool has_axis(JointKind kind) {
    return kind == JointKind::hinge || kind == JointKind::slider || kind == JointKind::universal;
}
/// Kinds with free axes, which may have springs, stops, friction and a motor.
constexpr bool has_free_axis(JointKind kind) {
    return kind == JointKind::hinge || kind == JointKind::slider || kind == JointKind::distance ||
           kind == JointKind::universal || kind == JointKind::spherical;
}
/// Kinds whose free axes are angles.
constexpr bool turns_freely(JointKind kind) {
    return kind == JointKind::hinge || kind == JointKind::universal || kind == JointKind::spherical;
}
/// Kinds that join a place of one rod or body to a place of another.
constexpr bool joins_places(JointKind kind) {
    return kind != JointKind::side_by_side && kind != JointKind::tip_to_side;
}

/// Name of the second side of joints to a fixed place.
inline constexpr std::string_view world_name = "world";

/// Rods of both groups that are joined, by their numbers in a copy: same i and i, next i and i + 1, listed.
enum class JointPairs { same, next, listed };
inline constexpr std::string_view joint_pairs_names[] = {"same", "next", "listed"};

/// Springs and dashpots of a joint.                                                                      theory.md
/// (69)-(72)
struct JointLaw {
    double stiffness = 0;           ///< k, N/m
    double damping = 0;             ///< nu, N s/m
    double torsional_stiffness = 0; ///< k_t, N m/rad
    double torsional_damping = 0;   ///< nu_t, N m s/rad
    double repulsion = 0;           ///< k_r, N/m^1.5
    bool rope = false;              ///< distance: pulls only
    double cone = 0;                ///< spherical: largest angle between both axes, rad; 0: without limit
    Vec3d along{1, 1, 1};           ///< bushing: shares of k and nu along d1, d2, d3 of the first
    Vec3d about{1, 1, 1};           ///< bushing: shares of k_t and nu_t about them

    bool damped() const { return damping > 0 || torsional_damping > 0; }
    bool turns() const { return torsional_stiffness > 0 || torsional_damping > 0; }
    void fields(FieldVisitor& f);
};

/// When a joint is made, and comes to an end.
struct JointEvents {
    double from = 0, until = 0; ///< s; until 0: never
    double break_force = 0;     ///< N; 0: never
    double break_strain = 0;    ///< of two places that are one node; 0: never

    bool any() const { return from > 0 || until > 0 || break_force > 0 || break_strain > 0; }
    void fields(FieldVisitor& f);
};

struct JointSpec {
    JointKind kind = JointKind::spherical;
    std::vector<std::string> between; ///< two groups, a group and itself, or a group and the world
    JointPairs pairs = JointPairs::same;
    std::vector<long> first, second; ///< listed: numbers of rods
    std::vector<double> at{1, 0};    ///< places on both, over the length; of a body unused
    std::optional<Vec3d> place;      ///< of the joint at the start, m, in the axes of the assembly
    Vec3d axis{0, 0, 0};             ///< of a hinge or slider, on the first of universal; at the start, as `place`;
                                     ///< of the cone and twist of spherical
    Vec3d second_axis{0, 0, 0};      ///< universal: on the second
    double length = 0;               ///< distance, m; 0: that at the start
    double gap = 0; ///< m: elements whose surfaces are farther apart are not side by side; 0: 1 % of their radii
    JointLaw law;
    AxisSpec axis_law;     ///< along the free axis
    AxisSpec about_second; ///< universal: about the second axis
    JointEvents events;
    std::vector<std::string> stages; ///< in which it holds; empty: all
    std::string name;                ///< of its columns of the time series; empty: none
    std::string source;              ///< file:line of the table, for messages

    void take_away_dashpots() {
        law.damping = law.torsional_damping = 0;
        for (AxisSpec* axis : {&axis_law, &about_second})
            axis->damping = axis->stop_damping = axis->friction_damping = 0;
    }
    /// True where something acts along free axes.
    bool has_axes() const { return axis_law.any() || about_second.any() || law.cone > 0; }
    bool has_motor() const {
        return axis_law.motor.kind != MotorKind::none || about_second.motor.kind != MotorKind::none;
    }
    bool has_friction() const { return axis_law.friction > 0 || about_second.friction > 0; }
    /// Axis of cone and twist of a spherical joint, and a direction across it, at the start.
    Vec3d twist_axis() const;
    Vec3d across_twist() const;
    /// Reads the formulas of motors.
    void use(const FormulaScope& names);
    /// True where joints of different rods have motors of their own.
    bool motors_by_rod() const { return axis_law.motor.by_rod() || about_second.motor.by_rod(); }
    /// `rod`: number of the first side's rod in its group.
    MotorsNow<double> motors_at(double time, double rod) const;
    /// Turns the motor of a spherical joint from the axes of the assembly into its own directions.
    MotorsNow<double> along_own_directions(const MotorsNow<double>& lab) const;
    bool to_world() const { return between.size() == 2 && between[1] == world_name; }
    void fields(FieldVisitor& f);

private:
    void place_fields(FieldVisitor& f);
};

} // namespace skein
