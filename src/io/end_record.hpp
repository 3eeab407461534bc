// Records of a run's last step that no interval asked for. end.json names them before they are written: a run that goes
// on takes them back, and its files are those of a run that never stopped. Root only.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace skein {

struct EndRecord {
    std::int64_t step = 0;
    std::vector<std::string> files; ///< by name in the directory; observables.csv stands for its last row
};

/// Writes <directory>/end.json.
void write_end_record(const std::string& directory, const EndRecord& record);

/// Removes what end.json names, then end.json. A directory without one stays as it is, and so does any file that is
/// none of that step's frames and tables.
void take_back_end(const std::string& directory);

} // namespace skein
