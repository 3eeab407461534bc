#include "io/csv_header.hpp"

#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

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
    find_id(header, placement);
    for (std::size_t c = 0; c < cells.size(); ++c)
        if (!header.plain[c].empty() && std::count(header.plain.begin(), header.plain.end(), header.plain[c]) > 1)
            header.refuse(fmt::format("two columns '{}'", shown(header.names[c])));
    if (lines.next(line)) header.past = lines.offset();
    else header.past = header.past + 2; // past the end
    return header;
}

} // namespace skein
