// Counts of a scene that this machine has no memory for, found before anything of their size is made.
#pragma once

#include "physics/scene_spec.hpp"

namespace skein {

struct Plan;

/// Elements of a rod, rods that are packed, and copies of an assembly are worked out one by one wherever a scene is
/// read. Throws InputError naming the table, the count, what they need and what is free.
void refuse_beyond_memory(const SceneSpec& scene);

/// The state of a run on this machine alone: what `skein check` looks at.
void refuse_run_beyond_memory(const SceneSpec& scene, const Plan& plan);

} // namespace skein
