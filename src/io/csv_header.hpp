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
    std::vector<std::string> plain;  ///< lower case, "_" for blanks, no unit; empty: skipped by placement.ignore
    std::vector<double> unit;        ///< m, of a column whose name ends with one in brackets; 0: placement.unit
    std::size_t id = none;           ///< column that names the rod of a row
    static constexpr std::size_t none = static_cast<std::size_t>(-1);

    /// Throws InputError naming the line.
    [[noreturn]] void refuse(const std::string& what) const;
    /// Number in units of `given`, m, of a number in column c, which is a length.
    double over(std::size_t c, double given) const { return unit[c] > 0 ? unit[c] / given : 1; }
    /// Throws where a column that is no length names a unit.
    void refuse_unit(std::size_t c) const;
};

/// Reads the first line that is neither empty nor a comment (`#`).
CsvHeader read_header(const std::string& path, const Placement& placement);

} // namespace skein
