// Suggestions for misspelt names.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Least number of insertions, deletions, replacements and swaps of neighbours that turn a into b (Damerau-Levenshtein
/// distance, no letter edited twice).
int edit_distance(std::string_view a, std::string_view b);

/// Nearest of `names`, the first among equals; empty where none is near. An abbreviation counts as one edit.
std::string_view nearest_name(std::string_view given, std::span<const std::string_view> names);

/// "; did you mean 'length'?" where a name is near, else "; <otherwise> a, b, c".
std::string suggestion(std::string_view given, std::span<const std::string_view> names, std::string_view otherwise);

/// "a, b, c"
std::string joined(std::span<const std::string_view> names);

} // namespace skein
