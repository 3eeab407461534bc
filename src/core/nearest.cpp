#include "core/nearest.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace skein {

int edit_distance(std::string_view a, std::string_view b) {
    const std::size_t n = b.size();
    std::vector<int> two_above(n + 1), above(n + 1), row(n + 1);
    for (std::size_t j = 0; j <= n; ++j) row[j] = static_cast<int>(j);
    for (std::size_t i = 1; i <= a.size(); ++i) {
        two_above.swap(above);
        above.swap(row);
        row[0] = static_cast<int>(i);
        for (std::size_t j = 1; j <= n; ++j) {
            const int replaced = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            row[j] = std::min({above[j] + 1, row[j - 1] + 1, replaced});
            const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped) row[j] = std::min(row[j], two_above[j - 2] + 1);
        }
    }
    return row[n];
}

std::string_view nearest_name(std::string_view given, std::span<const std::string_view> names) {
    std::string_view nearest;
    int fewest = 0;
    for (const std::string_view name : names) {
        const int letters = static_cast<int>(std::max(given.size(), name.size()));
        const bool abbreviated = given.size() >= 3 && name.starts_with(given);
        const int edits = abbreviated ? 1 : edit_distance(given, name);
        // A third of the letters may be wrong; with more, a suggestion misleads more often than it helps.
        const bool near = edits <= std::max(1, letters / 3) && edits < letters;
        if (!near || (!nearest.empty() && edits >= fewest)) continue;
        nearest = name;
        fewest = edits;
    }
    return nearest;
}

std::string suggestion(std::string_view given, std::span<const std::string_view> names, std::string_view otherwise) {
    if (const std::string_view near = nearest_name(given, names); !near.empty())
        return fmt::format("; did you mean '{}'?", near);
    return fmt::format("; {} {}", otherwise, joined(names));
}

std::string joined(std::span<const std::string_view> names) { return fmt::format("{}", fmt::join(names, ", ")); }

} // namespace skein
