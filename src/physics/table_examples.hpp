// An example for each table of a scene, for the reference page.
#pragma once

#include <string_view>

namespace skein {

/// TOML of a few lines for KeyEntry::table or "constants"; empty: there is none. A sub-table stands as in a scene,
/// below its [[rods]] or its other table. Groups of other tables are called "arm" and "leg".
std::string_view example_of(std::string_view table);

} // namespace skein
