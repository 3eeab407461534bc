// Comma-separated numbers: a line of names, then rows of as many numbers.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

struct CsvTable {
    std::vector<std::string> names;
    std::vector<std::vector<double>> columns; ///< [names][rows]
};

/// Throws IoError with the file and the faulty line.
CsvTable read_csv(const std::string& path);

/// Cells of a line without blanks and quotes around them, and without a byte order mark.
std::vector<std::string_view> csv_cells(std::string_view line);
/// Number of a cell, if it is one.
std::optional<double> csv_number(std::string_view cell);

} // namespace skein
