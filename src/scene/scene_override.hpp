// --set path=value: one key of a scene's TOML tree replaced or added. Stages change scenes in the same words.
#pragma once

#include "scene/scene_toml.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// "path=value" taken apart; the value in TOML, or, where it is none, as the text it is.
struct KeyValue {
    std::vector<std::string> path; ///< parts between the dots
    TomlValue value;
};

/// Throws InputError at `place` where the text is something else.
KeyValue key_value(const std::string& text, const Place& place);

/// Number of the table of a list that part of a path means: by its name or kind, of all `names`, or by its number.
/// Throws InputError at `place` where there is none, or more than one.
std::size_t number_of_table(const std::string& list, const std::string& part, std::span<const std::string_view> names,
                            const Place& place);

/// Throws InputError "--set path=value: ..." where the path leads nowhere. Whether the key exists and takes the value
/// is left to the reader: it finds the new value under the override's name.
void apply_override(TomlValue& root, const std::string& override);

} // namespace skein
