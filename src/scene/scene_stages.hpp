// A scene as it is in one of its stages: changes of all stages so far, tables that act in it, and what goes on from
// where the stage before has left it.                                                                 docs/stages.md
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/core/objections.hpp"

#include <span>
#include <string>
#include <vector>

namespace skein {

/// The scene in stage begins.size() - 1. `begins`: times at which the stages so far have begun, s. Throws InputError
/// where a change cannot be made.
SceneSpec stage_scene(const SceneSpec& scene, std::span<const double> begins);

/// True where ends of groups are held alike, and caught alike.
bool ends_alike(const std::vector<RodSpec>& a, const std::vector<RodSpec>& b);
/// Holds ends as those of other groups are held, and have been caught.
void hold_ends_like(const std::vector<RodSpec>& others, std::vector<RodSpec>& rods);
/// Numbers the ends that a branch catches, and those that were caught before: all that differ do so in their numbers.
void catch_ends_of_branch(std::vector<RodSpec>& parent, std::vector<RodSpec>& branch);

/// True where a motion that holds an end counts from the begin of the stage.
bool led_from_stage(const RodSpec& rods);

/// The scene with the keys that stages up to this one change, and all else as written.
SceneSpec with_changes(SceneSpec scene, std::size_t stage);

/// Times at which stages up to `stage` begin where none ends by a condition, s.
std::vector<double> nominal_begins(const SceneSpec& scene, std::size_t stage);

/// The scene with its formulas at work in the first stage alone.
SceneSpec as_it_begins(SceneSpec scene);

/// Objects to contradictions in [[stage]] and the keys `stages`.
void check_stages(const SceneSpec& scene, Objections& objections);

/// Objects to changes of stages that make no scene.
void check_changes(const SceneSpec& scene, Objections& objections);

/// Changes of a stage in words, one for each key: "rods.arm.material.E = 2e6".
std::vector<std::string> stage_changes(const SceneSpec& scene, std::size_t stage);

} // namespace skein
