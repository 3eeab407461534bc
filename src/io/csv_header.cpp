#include "io/csv_header.hpp"

#include "io/csv_table.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

namespace skein {

namespace {

constexpr std::string_view names_of_rods[] = {"filament", "fibre",   "fiber", "track", "trace", "rod",
                                              "curve",    "contour", "hair",  "yarn",  "id"};

/// A name in small letters, with "_" for blanks and hyphens.
std::string plain_name(std::string_view name) {
    std::string plain(name);
    for (char& c : plain) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
        if (c == ' ' || c == '-') c = '_';
    }
    return plain;
}

bool names_rod(std::string_view plain) {
    if (plain.ends_with("_id")) plain.remove_suffix(3);
    return std::find(std::begin(names_of_rods), std::end(names_of_rods), plain) != std::end(names_of_rods);
}

/// Length that a text names, m: "um", or "0.3 um", as of a voxel.
std::optional<double> length_of(std::string_view text) {
    constexpr std::pair<std::string_view, double> units[] = {
        {"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"\xC2\xB5m", 1e-6}, {"\xCE\xBCm", 1e-6}, {"nm", 1e-9}};
    const std::size_t begin = text.find_first_not_of(' ');
    if (begin == std::string_view::npos) return {};
    text = text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
    for (const auto& [name, value] : units) {
        if (!text.ends_with(name)) continue;
        const std::string_view before = text.substr(0, text.size() - name.size());
        if (before.empty()) return value;
        if (before.back() != ' ' && (before.back() < '0' || before.back() > '9')) continue; // another unit
        const std::optional<double> number = csv_number(before.substr(0, before.find_last_not_of(' ') + 1));
        if (number && *number > 0 && std::isfinite(*number)) return *number * value;
    }
    return {};
}

/// Takes units in brackets from the names of columns.
void find_units(CsvHeader& header) {
    header.unit.assign(header.names.size(), 0);
    for (std::size_t c = 0; c < header.names.size(); ++c) {
        const std::string_view name = header.names[c];
        const std::size_t open = name.rfind('[');
        if (header.plain[c].empty() || !name.ends_with(']') || open == std::string_view::npos) continue;
        const std::optional<double> length = length_of(name.substr(open + 1, name.size() - open - 2));
        if (!length)
            header.refuse(
                fmt::format("column '{}': the unit in brackets is none of m, cm, mm, um and nm, with a number "
                            "above 0 before it or without; placement.ignore skips the column",
                            shown(name)));
        header.unit[c] = *length;
        const std::string_view before = name.substr(0, open);
        header.plain[c] = plain_name(before.substr(0, before.find_last_not_of(" _") + 1));
    }
}

void skip_ignored(CsvHeader& header, const Placement& placement) {
    for (const std::string& ignored : placement.ignore) {
        const auto found = std::find(header.names.begin(), header.names.end(), ignored);
        if (found == header.names.end())
            header.refuse(fmt::format("has no column '{}', which placement.ignore names", shown(ignored)));
        header.plain[static_cast<std::size_t>(found - header.names.begin())].clear();
    }
}

void find_id(CsvHeader& header, const Placement& placement) {
    if (!placement.id.empty()) {
        const auto found = std::find(header.names.begin(), header.names.end(), placement.id);
        if (found == header.names.end())
            header.refuse(fmt::format("has no column '{}', which placement.id names", shown(placement.id)));
        header.id = static_cast<std::size_t>(found - header.names.begin());
        return;
    }
    for (std::size_t c = 0; c < header.plain.size(); ++c) {
        if (!names_rod(header.plain[c])) continue;
        if (header.id != CsvHeader::none)
            header.refuse(fmt::format("'{}' and '{}' may both name the rod: placement.id says which, and "
                                      "placement.ignore skips the other",
                                      shown(header.names[header.id]), shown(header.names[c])));
        header.id = c;
    }
}

} // namespace

void CsvHeader::refuse(const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", path, std::max<std::int64_t>(line, 1), what));
}

void CsvHeader::refuse_unit(std::size_t c) const {
    if (unit[c] > 0) refuse(fmt::format("column '{}' is no length and has no unit", shown(names[c])));
}

CsvHeader read_header(const std::string& path, const Placement& placement) {
    CsvHeader header{.path = path};
    TextLines lines(path);
    std::string_view line;
    do {
        if (!lines.next(line)) throw InputError(fmt::format("{}: it contains no names of columns", path));
    } while (line.find_first_not_of(" \t") == std::string_view::npos || line.starts_with('#'));
    header.line = lines.line();
    header.past = lines.offset() + static_cast<std::int64_t>(line.size());
    if (line.starts_with("\xFF\xFE") || line.starts_with("\xFE\xFF"))
        header.refuse("is text in UTF-16: save it as UTF-8");
    if (line.find('\r') != std::string_view::npos)
        header.refuse("lines end with a carriage return alone: save the file with line feeds");
    header.separator = separator_of(line);
    std::vector<std::string_view> cells;
    if (!split(line, header.separator, cells)) header.refuse("the quotes of the names of columns are wrong");
    header.names.assign(cells.begin(), cells.end());
    for (const std::string& name : header.names) header.plain.push_back(plain_name(name));
    skip_ignored(header, placement);
    find_units(header);
    find_id(header, placement);
    for (std::size_t c = 0; c < cells.size(); ++c)
        if (!header.plain[c].empty() && std::count(header.plain.begin(), header.plain.end(), header.plain[c]) > 1)
            header.refuse(fmt::format("two columns '{}'", shown(header.names[c])));
    if (lines.next(line)) header.past = lines.offset();
    else header.past = header.past + 2; // past the end
    return header;
}

} // namespace skein
