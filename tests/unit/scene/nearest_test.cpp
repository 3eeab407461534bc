#include "core/nearest.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace skein {
namespace {

/// The recursion the table of edit_distance() fills, written down as it stands in the books.
int distance_by_recursion(std::string_view a, std::string_view b) {
    if (a.empty() || b.empty()) return static_cast<int>(a.size() + b.size());
    const auto without = [](std::string_view s, std::size_t n) { return s.substr(0, s.size() - n); };
    int best = std::min({distance_by_recursion(without(a, 1), b) + 1, distance_by_recursion(a, without(b, 1)) + 1,
                         distance_by_recursion(without(a, 1), without(b, 1)) + (a.back() == b.back() ? 0 : 1)});
    const bool swapped = a.size() > 1 && b.size() > 1 && a.back() == b[b.size() - 2] && b.back() == a[a.size() - 2];
    if (swapped) best = std::min(best, distance_by_recursion(without(a, 2), without(b, 2)) + 1);
    return best;
}

TEST(EditDistance, EqualsTheRecursion) {
    const std::string_view words[] = {"", "a", "ab", "ba", "time", "tiem", "emit", "length", "lenght", "ca", "abc"};
    for (const auto a : words)
        for (const auto b : words) EXPECT_EQ(edit_distance(a, b), distance_by_recursion(a, b)) << a << " " << b;
}

TEST(NearestName, FindsSlipsAndAbbreviationsOnly) {
    const std::vector<std::string_view> names = {"length", "elements", "dt", "duration", "acceleration"};
    EXPECT_EQ(nearest_name("lenght", names), "length");
    EXPECT_EQ(nearest_name("element", names), "elements");
    EXPECT_EQ(nearest_name("dtt", names), "dt");
    EXPECT_EQ(nearest_name("acc", names), "acceleration");
    EXPECT_EQ(nearest_name("width", names), "");
    EXPECT_EQ(nearest_name("xy", names), "");
    EXPECT_EQ(nearest_name("", names), "");
}

TEST(Suggestion, ListsTheNamesWhereNoneIsNear) {
    const std::vector<std::string_view> names = {"free", "pinned"};
    EXPECT_EQ(suggestion("pined", names, "it is one of"), "; did you mean 'pinned'?");
    EXPECT_EQ(suggestion("glued", names, "it is one of"), "; it is one of free, pinned");
}

} // namespace
} // namespace skein
