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

std::vector<std::string_view> cells_of(std::string_view line) {
    std::vector<std::string_view> cells;
    for (std::size_t begin = 0; begin <= line.size();) {
        const std::size_t end = std::min(line.find(',', begin), line.size());
        cells.push_back(trimmed(line.substr(begin, end - begin)));
        begin = end + 1;
    }
    return cells;
}

} // namespace

CsvTable read_csv(const std::string& path) {
    const std::string text = read_file(path);
    std::string_view rest = text;
    if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3); // of a spreadsheet's UTF-8
    CsvTable table;
    for (int number = 1; !rest.empty(); ++number) {
        const std::string_view line = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(rest.size(), line.size() + 1));
        if (trimmed(line).empty()) continue;
        const auto cells = cells_of(line);
        if (table.names.empty()) {
            table.names.assign(cells.begin(), cells.end());
            table.columns.resize(cells.size());
            continue;
        }
        if (cells.size() != table.names.size())
            throw IoError(fmt::format("{}:{}: expected {} numbers, as the first line names them, found {}", path,
                                      number, table.names.size(), cells.size()));
        for (std::size_t c = 0; c < cells.size(); ++c) {
            const std::string_view digits = cells[c].substr(cells[c].starts_with('+') ? 1 : 0);
            double value = 0;
            const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
            if (error != std::errc{} || stop != digits.data() + digits.size())
                throw IoError(fmt::format("{}:{}: '{}' is no number", path, number, cells[c]));
            table.columns[c].push_back(value);
        }
    }
    return table;
}

} // namespace skein
