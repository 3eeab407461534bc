// Names of the columns of a text file of rods.
#pragma once

#include "io/text_rows.hpp"
#include "skein/placement/placement_spec.hpp"

#include <string>
#include <vector>

namespace skein {

struct CsvHeader {
    std::string path;
    char separator = ',';
    std::int64_t line = 0, past = 0; ///< number of its line, and offset of the next one
    std::vector<std::string> names;  ///< as written
    std::vector<std::string> plain;  ///< lower case, "_" for blanks; empty: skipped by placement.ignore
    std::size_t id = none;           ///< column that names the rod of a row
    static constexpr std::size_t none = static_cast<std::size_t>(-1);

    /// Throws InputError naming the line.
    [[noreturn]] void refuse(const std::string& what) const;
};

/// Reads the first line that is neither empty nor a comment (`#`).
CsvHeader read_header(const std::string& path, const Placement& placement);

} // namespace skein
