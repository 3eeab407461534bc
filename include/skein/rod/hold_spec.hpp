// Keys of nodes and elements held inside a rod.
#pragma once

#include "skein/core/fields.hpp"

#include <string>
#include <vector>

namespace skein {

/// Rates that stay zero. Negative numbers count from the end, -1 is the last.
struct Hold {
    std::vector<long> nodes;
    std::vector<long> elements;
    std::string directions = "xyz"; ///< lab directions in which the nodes do not move
    std::string axes = "xyz";       ///< lab axes about which the elements do not turn

    bool any() const { return !nodes.empty() || !elements.empty(); }
    void fields(FieldVisitor& f) {
        f.visit({.name = "nodes", .unit = "-", .text = "nodes that do not move; -1 is the last"}, nodes);
        f.visit({.name = "elements", .unit = "-", .text = "elements that do not turn; -1 is the last"}, elements);
        f.visit({.name = "directions", .text = "lab directions in which the nodes are held"}, directions);
        f.visit({.name = "axes", .text = "lab axes about which the elements are held"}, axes);
    }
};

} // namespace skein
