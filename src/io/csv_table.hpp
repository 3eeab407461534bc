// Files of comma-separated numbers: a line of names, then rows of as many numbers.
#pragma once

#include <string>
#include <vector>

namespace skein {

struct CsvTable {
    std::vector<std::string> names;
    std::vector<std::vector<double>> columns; ///< [names][rows]
};

/// Throws IoError naming the file, and the line that is at fault.
CsvTable read_csv(const std::string& path);

} // namespace skein
