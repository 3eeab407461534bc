#include "core/share_text.hpp"

#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr int fewest_digits = 3, most_digits = 17;

std::string bytes_text(double bytes, int digits) {
    constexpr std::array<std::string_view, 5> units = {"B", "kB", "MB", "GB", "TB"};
    std::size_t unit = 0;
    for (; unit + 1 < units.size() && bytes >= 999.5; ++unit) bytes *= 1e-3;
    if (bytes >= 999.5) return fmt::format("{:.0f} {}", bytes, units[unit]);
    return fmt::format("{:.{}g} {}", bytes, digits, units[unit]);
}

} // namespace

std::string share_text(double share) {
    std::string text;
    for (int digits = fewest_digits; digits <= most_digits; ++digits) {
        text = fmt::format("{:.{}g}", share, digits);
        if (text != "1" || share == 1) break;
    }
    return text;
}

std::string bytes_text(double bytes) { return bytes_text(bytes, fewest_digits); }

std::pair<std::string, std::string> bytes_texts(std::uint64_t a, std::uint64_t b) {
    std::pair<std::string, std::string> both;
    for (int digits = fewest_digits; digits <= most_digits; ++digits) {
        both = {bytes_text(static_cast<double>(a), digits), bytes_text(static_cast<double>(b), digits)};
        if (both.first != both.second || a == b) return both;
    }
    return {fmt::format("{} B", a), fmt::format("{} B", b)};
}

} // namespace skein
