// External loads and damping as a scene states them.
#pragma once

#include "loads/damping.hpp"
#include "skein/loads/load.hpp"

#include <string>
#include <vector>

namespace skein {

/// [[load]]: a load and the groups of rods it acts on, all if the list is empty.
struct LoadSpec {
    Load load;
    std::vector<std::string> rods;
    std::vector<std::string> stages; ///< in which it acts; empty: all
    std::string source;              ///< file:line of the table, for messages

    /// Kind, groups, and the load's own keys. A visitor that changes the kind resets the load to its defaults.
    void fields(FieldVisitor& f);
    static std::span<const std::string_view> kinds() { return load_kinds(); }
    static LoadSpec of_kind(int kind) { return {.load = make_load(kind), .rods = {}, .stages = {}, .source = {}}; }
    int kind_number() const { return load.number(); }
};

/// [[damping]]
struct DampingSpec {
    Damping damping;
    std::vector<std::string> rods, stages;
    std::string source;

    void fields(FieldVisitor& f);
};

} // namespace skein
