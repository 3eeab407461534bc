// External loads and damping as a scene states them.
#pragma once

#include "loads/damping.hpp"
#include "skein/loads/load.hpp"

#include <string>
#include <vector>

namespace skein {

/// A load and the groups of rods it acts on (all where the list is empty).
struct LoadSpec {
    Load load;
    std::vector<std::string> rods;
    std::string source; ///< file:line of the table, for messages
};

struct DampingSpec {
    Damping damping;
    std::vector<std::string> rods;
    std::string source;
};

} // namespace skein
