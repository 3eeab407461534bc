// Runs that begin with the state of another one, under changed keys.                                       theory.md
// (63)
#pragma once

#include "io/checkpoint.hpp"
#include "scene/scene_rebuild.hpp"
#include "skein/time/clock.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Checkpoints that `name` may mean, the one to be tried first in front. `folder`: where relative names start. Throws
/// InputError where there are none. Collective.
std::vector<std::string> checkpoints_of(const Communicator& comm, const std::string& name, const std::string& folder);

/// Clock with steps of another length, at the step nearest to the present time, which does not change.
Clock continued(const Clock& clock, double dt, Integrator integrator);

/// Throws InputError naming each key of a branch that may not differ from its parent's.
void refuse_other_rods(const CheckpointInfo& parent, const std::string& physics);

struct BranchOf {
    const SceneSpec& scene;
    double dt;
    const std::string& physics;       ///< of the branch
    const std::vector<RodSpec>& held; ///< groups with ends as the world holds them
    std::size_t stages = 0;           ///< that have begun in the world; 0: it has none
    std::string newest = {};          ///< checkpoint to begin with, as newer ones are damaged; empty: the newest
};

/// What a checkpoint of a branch itself would say at its first step, and groups with ends as it holds them from there.
struct Branched {
    CheckpointInfo info;
    std::vector<RodSpec> rods;
};

/// Thrown where the ends of a state are held in another way than those of the rods that it is to be loaded into.
struct OtherEnds {
    std::vector<RodSpec> rods; ///< groups with these ends
    std::string file;          ///< of the checkpoint; newer ones are damaged
};

/// Loads the state that a scene begins with into `rods`, positions and directors moved to where the branch's step has
/// them, and ends held as the parent's. Damaged ones are passed over and told through `warn` unless the scene names
/// their step. Throws OtherStage or OtherEnds where the state is one of these. Collective.
Branched begin_branch(const Communicator& comm, const BranchOf& branch, std::span<const RodGroup> groups, Rods& rods,
                      std::span<const std::string> kept, const std::function<void(const std::string&)>& warn);

/// Groups with ends caught as a branch of this ancestry, or one before it, has caught them.
std::vector<RodSpec> with_caught_ends(std::vector<RodSpec> rods, const std::string& ancestry);

/// The physics with what a branch's checkpoints say of its ancestry; as it is where there is none.
std::string with_ancestry(const std::string& physics, const std::string& ancestry);

/// A scene file's text for a branch, with `skein branch`'s line about where it comes from.
std::string branch_file(const SceneSpec& scene, const CheckpointInfo& parent, const std::vector<KeyChange>& changes);

} // namespace skein
