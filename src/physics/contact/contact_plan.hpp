// Contact in the plan of a run.
#pragma once

#include "contact/contact_solver.hpp"
#include "contact/contact_spec.hpp"
#include "physics/contact/contact_estimate.hpp"
#include "physics/contact/speed_estimate.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>

namespace skein {

/// Contact between rods. Without it nothing is searched, kept or sent.
struct ContactPlan {
    ContactSpec spec;
    ContactLaws laws; ///< by pair of groups
    bool automatic_stiffness = false;
    std::shared_ptr<const JoinedGaps> joined; ///< null where rods of one copy never touch

    /// `has_tangents`: loads come with their slopes, of bodies that are nearer than `meeting_zone` too, m.
    ContactScene scene(std::span<const RodGroup> groups, bool has_tangents = false, double meeting_zone = 0) const {
        ContactScene scene = contact_scene(groups, spec, laws, joined);
        scene.has_tangents = has_tangents;
        scene.meeting_zone = meeting_zone;
        return scene;
    }
};

/// Estimates for rods that may touch each other or walls.
struct TouchPlan {
    ContactEstimate estimate;
    SpeedEstimate speeds;
    std::optional<Vec3d> gravity; ///< that of all rods, where it is one for all; m/s^2
    double mass = 0;              ///< of all rods, kg
    double mass_radius = 0;       ///< sum of masses times radii, kg m
};

/// A law in a printed plan.
std::string law_text(const ContactLaw& law);

} // namespace skein
