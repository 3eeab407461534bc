#include "physics/rods/rotary_inertia.hpp"

#include "physics/group_names.hpp"
#include "physics/wave_looker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace skein {

namespace {

bool has_joint(const SceneSpec& scene, const RodSpec& rods, const auto& of_joint) {
    return std::any_of(scene.joints.begin(), scene.joints.end(), [&](const JointSpec& joint) {
        const bool joins = std::find(joint.between.begin(), joint.between.end(), rods.name) != joint.between.end();
        return joins && of_joint(joint);
    });
}

bool is_joined(const SceneSpec& scene, const RodSpec& rods) {
    return has_joint(scene, rods, [](const JointSpec&) { return true; });
}

/// A rod that nothing holds.
bool is_free(const SceneSpec& scene, const RodSpec& rods) {
    return rods.start == EndKind::free && rods.end == EndKind::free && !rods.hold.any() && !is_joined(scene, rods);
}

/// Largest turn of an end, rad, by its motion at times of the run.
double largest_turn(const SceneSpec& scene, EndMotion motion) {
    if (!motion.turns()) return 0;
    motion.use(names_for_formulas(scene));
    constexpr int times = 400;
    double largest = 0;
    for (int i = 0; i <= times; ++i)
        largest = std::max(largest, norm(motion.turn(scene.time.duration * i / times).value));
    return largest;
}

std::string spin(const SceneSpec& scene, const RodSpec& rods) {
    if (!zero(rods.shape.element_spin)) return "'element_spin' makes its sections spin";
    if (!zero(rods.shape.angular_velocity)) return "'angular_velocity' makes its rods turn as a whole";
    for (const EndMotion* motion : {&rods.start_motion, &rods.end_motion})
        if (largest_turn(scene, *motion) > std::numbers::pi)
            return "a motion turns an end by more than half a turn, so that the rod spins or whirls";
    const auto spins = [](const JointSpec& joint) {
        return joint.axis_law.motor.kind == MotorKind::rate || joint.about_second.motor.kind == MotorKind::rate;
    };
    if (has_joint(scene, rods, spins)) return "a motor of kind rate keeps turning it";
    return is_free(scene, rods) ? "its rods are free, and turn as a whole" : "";
}

std::string impacts(const SceneSpec& scene, const RodSpec& rods) {
    if (scene.contact) return "[contact] lets its rods hit each other";
    for (const Wall& wall : scene.walls)
        if (names_group(wall.rods, rods.name)) return fmt::format("its rods hit wall '{}'", wall.name);
    const auto stops = [](const JointSpec& joint) {
        return !joint.axis_law.limits.empty() || !joint.about_second.limits.empty() || joint.law.cone > 0;
    };
    if (has_joint(scene, rods, stops)) return "a joint has stops, which it hits";
    const auto breaks = [](const JointSpec& joint) {
        return joint.events.break_force > 0 || joint.events.break_strain > 0;
    };
    if (has_joint(scene, rods, breaks)) return "a joint may break, and send waves along it";
    if (!zero(rods.shape.velocity) && !is_free(scene, rods))
        return "'velocity' throws its rods against what holds them";
    return "";
}

/// Ends or parts that are held in lab directions, of rods that each stand in another direction.
bool differs_by_rod(const RodSpec& rods) {
    const Placement& p = rods.placement;
    const bool turned = p.kind == PlacementKind::file || p.kind == PlacementKind::packing || !p.tangents.empty() ||
                        !p.normals.empty(),
               partly = (!rods.hold.nodes.empty() && rods.hold.directions.size() < 3) ||
                        (!rods.hold.elements.empty() && rods.hold.axes.size() < 3);
    return turned && (rods.ends_slide() || partly);
}

} // namespace

AutomaticInertia automatic_inertia(const SceneSpec& scene, const RodSpec& rods) {
    if (!is_joined(scene, rods)) return automatic_inertia(rods);
    RodSpec held = rods;
    for (EndKind* end : {&held.start, &held.end})
        if (*end == EndKind::free && !held.shape.closed) *end = EndKind::pinned;
    return automatic_inertia(held);
}

std::string rotary_inertia_matters(const SceneSpec& scene, const RodSpec& rods) {
    if (differs_by_rod(rods))
        return "its rods have directions of their own, and are held in lab directions: each bends in other modes";
    const std::string turning = spin(scene, rods);
    return turning.empty() ? impacts(scene, rods) : turning;
}

std::string driven_beyond(const SceneSpec& scene, const RodSpec& rods, const AutomaticInertia& chosen) {
    const double least = 1 / chosen.frequency;
    const auto beyond = [&](const std::string& what, const WaveLooker& wave) {
        if (wave.period < least)
            return fmt::format("{} of period {:.4g} s drives it, and bending is right to 1 % for periods above {:.4g} "
                               "s alone",
                               what, wave.period, least);
        if (2 * rods.shape.length / wave.wavelength > std::max(1, chosen.highest) + 1)
            return fmt::format("{} of wavelength {:.4g} m drives it, and bending is right to 1 % in the lowest {} "
                               "modes alone",
                               what, wave.wavelength, chosen.highest);
        return std::string();
    };
    for (const LoadSpec& spec : scene.loads) {
        LoadSpec copy = spec; // fields() hands out references to change
        WaveLooker wave;
        copy.fields(wave);
        if (!names_group(spec.rods, rods.name) || !spec.load.acts_on(rods)) continue;
        if (std::string told = beyond(fmt::format("load '{}'", spec.load.kind()), wave); !told.empty()) return told;
    }
    for (EndMotion motion : {rods.start_motion, rods.end_motion}) {
        WaveLooker wave;
        motion.fields(wave);
        if (std::string told = beyond("a motion of its end", wave); motion.period > 0 && !told.empty()) return told;
    }
    return "";
}

} // namespace skein
