// A line of the plan: one description for readers and for programs.
#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace skein {

struct PlanLine {
    std::string label;                ///< begins with two spaces where it belongs to the line before
    std::string text;                 ///< empty: it is not printed
    std::string key;                  ///< in JSON; empty: it has none
    nlohmann::ordered_json json = {}; ///< value there; null: the text
};

} // namespace skein
