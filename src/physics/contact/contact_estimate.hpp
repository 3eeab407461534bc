// Forces and overlaps of contacts expected before a step is taken, from what a scene says; and the stiffness that
// stiffness = "auto" stands for.                                                                         theory.md
// (58a), (58b)
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/rod/rod_group.hpp"

#include <span>
#include <string>
#include <vector>

namespace skein {

struct ContactEstimate {
    double force = 0;                  ///< of the contact that bears most, N; 0: nothing that the scene states presses
    std::string by;                    ///< "weight" or "pressure"
    double overlap = 0;                ///< of rods under it, over the smaller diameter; of the softest law
    std::vector<double> wall_overlaps; ///< the same of walls, in the order of expanded()
};

/// Outlook of a scene whose stiffnesses are numbers. `laws`: by pair of groups; null where rods do not feel each other.
ContactEstimate contact_estimate(const SceneSpec& scene, const ContactLaws* laws, std::span<const RodGroup> groups);

/// The scene with a number in place of every automatic stiffness. Throws InputError where there is nothing to find it
/// from.
SceneSpec with_stiffnesses(SceneSpec scene, std::span<const RodGroup> groups);

} // namespace skein
