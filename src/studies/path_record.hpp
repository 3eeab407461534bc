// What a path leaves beside its table, so that it can be gone on with: path_state.json.
#pragma once

#include "equilibrium/path.hpp"

#include <nlohmann/json.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace skein {

inline constexpr std::string_view path_record_name = "path_state.json";

struct PathRecord {
    nlohmann::ordered_json asked; ///< options that a path must have again, by their names on the command line
    int branch = 0;               ///< 1 once it has left for another branch
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    std::vector<double> limits, branches;
    nlohmann::ordered_json critical_slopes = nlohmann::ordered_json::array(); ///< at these, where some are asked for
    std::string reason;                                                       ///< why it does not go on; empty: it may
    PathMemory memory;
};

/// JSON, with all digits.
std::string to_text(const PathRecord& record);
/// Throws InputError where a directory has none, and IoError where it is damaged.
PathRecord read_path_record(const std::string& directory);
/// Throws InputError where a path that is asked for is not that of the record, is complete, ended by itself, or has as
/// many points as are asked for.
void require_unfinished(const PathRecord& record, const nlohmann::ordered_json& asked, int points);

} // namespace skein
