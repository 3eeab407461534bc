// A scene taken back from what a checkpoint keeps of it, and changed: for branches and for `skein verify`.
#pragma once

#include "physics/key_change.hpp"
#include "physics/scene_spec.hpp"
#include "skein/rod/rod_group.hpp"

#include <span>
#include <string>
#include <vector>

namespace skein {

/// Keys that decide the bits of a run: the scene's physics and the step, not how long it runs or what it writes.
/// Canonical JSON. `groups`: of the scene, whose files of rods are known by their digests, wherever they lie.
std::string physics_json(SceneSpec scene, std::span<const RodGroup> groups, double dt);

/// Keys that it leaves out: title, times and outputs, and the name of the scene's file. JSON.
std::string settings_json(const SceneSpec& scene);

/// The scene of both, with its step as a number. `name`: of the file that they are from, for messages. Throws
/// InputError where they make no scene of this program's.
SceneSpec rebuilt_scene(const std::string& physics, const std::string& settings, const std::string& name);
/// True where a step is automatic: then outputs enter it.
bool has_automatic_step(const std::string& settings);
/// The rebuilt scene with `overrides`, as for read_scene, and to begin with the state `from` and not with what it began
/// with itself.
SceneSpec branched_scene(const std::string& physics, const std::string& settings, const std::string& name,
                         const std::string& from, const std::vector<std::string>& overrides);

/// Keys that differ between two scenes.
std::vector<KeyChange> key_changes(const std::string& old_json, const std::string& new_json);

/// Changes from one physics to another under which a state means nothing: those of geometry, sections, elements and
/// groups, and of which physics there are. Ends that are held in another way are caught where they are.
std::vector<KeyChange> forbidden_changes(const std::string& old_physics, const std::string& new_physics);

/// "\n  time.dt: was 0.01, now 0.005" for each of the first few.
std::string text_of(const std::vector<KeyChange>& changes);

} // namespace skein
