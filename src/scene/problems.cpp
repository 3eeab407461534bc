#include "scene/problems.hpp"

#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr std::size_t most_reported = 10;
constexpr int widest_snippet = 120;

bool starts_character(char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }

/// Characters of UTF-8 text, which is what editors count columns in.
int characters(const std::string& text, int from, int to) {
    return static_cast<int>(std::count_if(text.begin() + from, text.begin() + to, starts_character));
}

struct Snippet {
    std::string line;
    int first, length; ///< bytes of `line` to mark
};

/// The line, or for a long one (a list of numbers) a window around the place.
Snippet window(const std::string& line, int first, int length) {
    const int size = static_cast<int>(line.size());
    if (size <= widest_snippet) return {line, first, length};
    const int begin = std::max(0, std::min(first - widest_snippet / 2, size - widest_snippet));
    const int shown = std::min(widest_snippet, size - begin);
    const std::string before = begin > 0 ? "..." : "", after = begin + shown < size ? "..." : "";
    const int start = first - begin;
    return {before + line.substr(static_cast<std::size_t>(begin), static_cast<std::size_t>(shown)) + after,
            start + static_cast<int>(before.size()), std::min(length, shown - start)};
}

std::string snippet(const Place& place, const std::string& whole_line) {
    const int size = static_cast<int>(whole_line.size());
    const int start = std::clamp(place.column - 1, 0, size);
    const auto [line, first, length] =
        window(whole_line, start, std::clamp(place.length, 1, std::max(1, size - start)));
    std::string indent;
    for (int i = 0; i < first; ++i)
        if (starts_character(nth(line, i))) indent += nth(line, i) == '\t' ? '\t' : ' ';
    const int marked = std::max(1, characters(line, first, std::min(first + length, static_cast<int>(line.size()))));
    return fmt::format("{:5} | {}\n{:5} | {}{}", place.line, line, "", indent,
                       std::string(static_cast<std::size_t>(marked), '^'));
}

} // namespace

std::string Place::table_name() const { return line > 0 ? fmt::format("{}:{}", text->name, line) : text->name; }

std::string message_at(const Place& place, const std::string& message) {
    if (place.text->lines.empty()) return fmt::format("{}: {}", place.text->name, message);
    const auto last = static_cast<int>(place.text->lines.size());
    const std::string& line = nth(place.text->lines, std::clamp(place.line, 1, last) - 1);
    const int column = 1 + characters(line, 0, std::clamp(place.column - 1, 0, static_cast<int>(line.size())));
    return fmt::format("{}:{}:{}: {}\n{}", place.text->name, place.line, column, message, snippet(place, line));
}

void Problems::add(const Place& place, const std::string& message) { found_.push_back({place, message}); }

void Problems::raise() const {
    if (found_.empty()) return;
    std::vector<Problem> sorted = found_;
    std::stable_sort(sorted.begin(), sorted.end(), [](const Problem& a, const Problem& b) {
        return std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
    });
    std::string text;
    for (std::size_t i = 0; i < std::min(sorted.size(), most_reported); ++i)
        text.append(i ? "\n" : "").append(message_at(sorted[i].place, sorted[i].message));
    if (sorted.size() > most_reported) text += fmt::format("\nand {} more", sorted.size() - most_reported);
    throw InputError(text);
}

} // namespace skein
