// Tables and keys of scenes for programs, each with unit, type, bounds and default.
#pragma once

#include <string>

namespace skein {

/// One JSON object: "tables" [{name, heading, list}], the top-level tables of a scene, and "keys" [{path, table, key,
/// type, unit, default, required, choices, above, at_least, at_most, text}]. Keys of loads stand under "load.<kind>". A
/// unit is that of SI, "-" of a pure number, "" of text. With a path only that key, or the keys of that table; empty
/// where there is none.
std::string description_json(const std::string& path = {});

/// "; did you mean 'rods.shape'?" where a key or table is near, else where all are listed.
std::string nearest_key(const std::string& path);

} // namespace skein
