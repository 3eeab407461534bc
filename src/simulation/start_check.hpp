// Places of bodies when a run begins: none deep in another, behind a wall, in an obstacle or outside the fluid. A run
// that goes on from a checkpoint, its own or another's, is not looked at. A stage that lets walls appear is.
#pragma once

#include "neighbourhood/neighbourhood.hpp"
#include "parallel/communicator.hpp"
#include "physics/scene_spec.hpp"
#include "plan/plan.hpp"
#include "simulation/world.hpp"
#include "tiles/rods.hpp"

#include <span>
#include <string>

namespace skein {

/// Throws InputError on all ranks alike where bodies in their start state stand so. `exposure`, of own bodies, and
/// `neighbourhood`: null where rods do not feel each other; they are left as they are. Collective.
void refuse_start(const Communicator& comm, const Threads& threads, const Plan& plan, std::span<const RodGroup> groups,
                  const Rods& rods, Exposure* exposure, Neighbourhood* neighbourhood);

/// Refuses overlaps of all bodies of a scene in this process, before anything is made, but for starts from checkpoints.
void refuse_start(const SceneSpec& scene, const Plan& plan, std::span<const RodGroup> groups);

/// Throws InputError on all ranks alike where a wall that stands in the stage of this plan, and did not before, would
/// appear where bodies are. Collective.
void refuse_new_walls(const World& world, const Plan& plan, const std::string& stage);

} // namespace skein
