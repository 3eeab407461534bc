// Begin of a run: with the scene, with a checkpoint of its own directory, or with the state of another run.
#pragma once

#include "io/checkpoint.hpp"
#include "physics/scene_spec.hpp"
#include "simulation/run_options.hpp"
#include "simulation/stages.hpp"

#include <optional>

namespace skein {

struct Start {
    std::optional<CheckpointInfo> found; ///< the checkpoint that holds the state; none: the scene's start
    bool resumes = false;                ///< it is one of this directory
};

/// Throws InputError where bodies of a scene begin in each other, behind walls or outside the fluid. Runs that begin
/// with a checkpoint pass. Collective.
void refuse_bad_start(World& world, const SceneSpec& scene, const RunOptions& options);

/// Loads the state that a run begins with into its world, which goes to the stage of that state. Collective.
Start start_of(World& world, Stages& stages, const SceneSpec& scene, const std::string& physics,
               const RunOptions& options);

} // namespace skein
