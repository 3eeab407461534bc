// A scene with other numbers of elements that is the same problem: what its keys say by element, node or cell goes
// along.
#pragma once

#include "physics/refinement.hpp"
#include "physics/scene_spec.hpp"

#include <string>
#include <vector>

namespace skein {

/// Lengths of elements share or add up; radii, curvatures and amplitudes are taken as linear between the places that
/// they are given at, middles of elements or vertices; held nodes stay where they are, an element held alone at an end
/// stays the last one; what a plane or a damping does per element or per node is shared; a scaled rotary inertia stays
/// that of the elements as given. A filter's rate stays: its damping of long waves is an error of the discretisation,
/// which goes away with it. Throws InputError naming the key where there is no rule:
/// states and rods of given nodes, elements held one by one inside a rod, odd numbers that are to be halved.
SceneSpec refined(const SceneSpec& scene, const Refinement& by);

/// Overrides that make the second of two scenes of the first, which has the same tables.
std::vector<std::string> changes_between(const SceneSpec& was, const SceneSpec& now);

/// Decisions of `refined` that the author of the scene should know, a line each.
std::vector<std::string> refinement_notes(const SceneSpec& scene);

} // namespace skein
