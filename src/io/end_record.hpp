// Records at a run's last step beyond its intervals. end.json names them before they are written. A run that continues
// removes them, so its files equal those of a run without interruption. Root only.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace skein {

struct EndRecord {
    std::int64_t step = 0;
    std::vector<std::string> files; ///< names in the directory; observables.csv stands for its last row
};

/// Writes <directory>/end.json.
void write_end_record(const std::string& directory, const EndRecord& record);

/// Removes the files that end.json names, then end.json, if there is one. Only frames and tables of that step are
/// removed.
void take_back_end(const std::string& directory);

} // namespace skein
