// Limits of the time step of a group: by their own modes, by contacts, loads and joints, and by the inertia that a
// fluid leaves them.
#pragma once

#include "contact/contact_limits.hpp"
#include "contact/wall_contacts.hpp"
#include "joints/joint_limits.hpp"
#include "physics/group_names.hpp"
#include "scene/plan.hpp"

namespace skein {

/// Calls f(law, largest overlap over the sum of radii, mass) for every contact that a group may have.
template <class F> void with_contact_laws(const SceneSpec& scene, const RodGroup& group, F&& f) {
    if (scene.contact) f(scene.contact->law, scene.contact->overlap, reduced_mass(group, group));
    for (const ContactPair& pair : scene.contact_pairs)
        if (names_group(pair.between, group.name())) f(pair.law, scene.contact->overlap, reduced_mass(group, group));
    for (const Wall& wall : scene.walls)
        if (wall.acts_on(group.name())) f(wall.law, ContactSpec{}.overlap, mass_at_wall(group));
}

/// Sets the limits of a group whose loads and share of its inertia are known, smallest first. `joints`: null where its
/// rods are not joined.
void find_limits(GroupPlan& p, const RodGroup& group, const SceneSpec& scene, const JointBounds* joints);

} // namespace skein
