#include "io/csv_table.hpp"

#include "io/files.hpp"
#include "skein/core/error.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>

#include <fmt/format.h>

namespace skein {

namespace {

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view blank = " \t\r\"";
    const std::size_t begin = text.find_first_not_of(blank);
    return begin == std::string_view::npos ? std::string_view()
                                           : text.substr(begin, text.find_last_not_of(blank) + 1 - begin);
}

} // namespace

std::vector<std::string_view> csv_cells(std::string_view line) {
    if (line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3); // byte order mark of spreadsheets
    std::vector<std::string_view> cells;
    for (std::size_t begin = 0; begin <= line.size();) {
        const std::size_t end = std::min(line.find(',', begin), line.size());
        cells.push_back(trimmed(line.substr(begin, end - begin)));
        begin = end + 1;
    }
    return cells;
}

std::optional<double> csv_number(std::string_view cell) {
    if (cell.starts_with('+')) cell.remove_prefix(1);
    double value = 0;
    const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc{} || stop != cell.data() + cell.size()) return std::nullopt;
    return value;
}

CsvTable read_csv(const std::string& path) {
    const std::string text = read_file(path);
    std::string_view rest = text;
    CsvTable table;
    for (int number = 1; !rest.empty(); ++number) {
        const std::string_view line = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(rest.size(), line.size() + 1));
        if (trimmed(line).empty()) continue;
        const auto cells = csv_cells(line);
        if (table.names.empty()) {
            table.names.assign(cells.begin(), cells.end());
            table.columns.resize(cells.size());
            continue;
        }
        if (cells.size() != table.names.size())
            throw IoError(fmt::format("{}:{}: expected {} numbers by the first line, found {}", path, number,
                                      table.names.size(), cells.size()));
        for (std::size_t c = 0; c < cells.size(); ++c) {
            const std::optional<double> value = csv_number(cells[c]);
            if (!value) throw IoError(fmt::format("{}:{}: '{}' is not a number", path, number, cells[c]));
            table.columns[c].push_back(*value);
        }
    }
    return table;
}

} // namespace skein
