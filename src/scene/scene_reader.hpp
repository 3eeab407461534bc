// Fills a SceneSpec, or a MachineFile, from a TOML tree, table by table; what does not fit the keys' descriptions goes
// to `problems`.
#pragma once

#include "physics/scene_spec.hpp"
#include "scene/machine_file.hpp"
#include "scene/problems.hpp"
#include "scene/scene_override.hpp"
#include "scene/scene_toml.hpp"

namespace skein {

SceneSpec read_tables(const TomlValue& root, Problems& problems);
/// Gives one key of a scene's physics, rods or bodies another value. Throws InputError at the value's place.
void change_scene(SceneSpec& scene, const KeyValue& change);

MachineFile read_machine_tables(const TomlValue& root, Problems& problems);

} // namespace skein
