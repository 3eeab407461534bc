// The name somebody probably meant.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Fewest insertions, deletions, replacements and swaps of neighbours that turn a into b (Damerau-Levenshtein distance,
/// no letter edited twice).
int edit_distance(std::string_view a, std::string_view b);

/// The closest of `names`, the first one among equals, an abbreviation counting as one edit; empty where none comes
/// near.
std::string_view nearest_name(std::string_view given, std::span<const std::string_view> names);

/// "; did you mean 'length'?" where a name is near, else "; <otherwise> a, b, c".
std::string suggestion(std::string_view given, std::span<const std::string_view> names, std::string_view otherwise);

/// "a, b, c"
std::string joined(std::span<const std::string_view> names);

} // namespace skein
