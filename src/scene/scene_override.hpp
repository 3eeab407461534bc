// --set path=value: one key of a scene's TOML tree replaced or added.
#pragma once

#include "scene/scene_toml.hpp"

#include <string>

namespace skein {

/// Throws InputError "--set path=value: ..." where the path leads nowhere. Whether the key exists and takes the value
/// is left to the reader: it finds the new value under the override's name.
void apply_override(TomlValue& root, const std::string& override);

} // namespace skein
