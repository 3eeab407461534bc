#include "formula/unit.hpp"
#include "skein/core/index.hpp"

#include <cctype>
#include <charconv>
#include <utility>

#include <fmt/format.h>

namespace skein {

namespace {

struct Named {
    std::string_view name;
    Unit unit;
};
//                                    m  kg   s   A  K
constexpr Named named[] = {
    {"m", {{1, 0, 0, 0, 0}}},  {"kg", {{0, 1, 0, 0, 0}}},  {"s", {{0, 0, 1, 0, 0}}},    {"A", {{0, 0, 0, 1, 0}}},
    {"K", {{0, 0, 0, 0, 1}}},  {"N", {{1, 1, -2, 0, 0}}},  {"Pa", {{-1, 1, -2, 0, 0}}}, {"J", {{2, 1, -2, 0, 0}}},
    {"W", {{2, 1, -3, 0, 0}}}, {"Hz", {{0, 0, -1, 0, 0}}}, {"T", {{0, 1, -2, -1, 0}}},  {"V", {{2, 1, -3, -1, 0}}},
    {"C", {{0, 0, 1, 1, 0}}},  {"rad", {{0, 0, 0, 0, 0}}}, {"1", {{0, 0, 0, 0, 0}}},    {"-", {{0, 0, 0, 0, 0}}}};

constexpr std::string_view common[] = {"-", "m",   "s",     "kg",    "A",     "K",       "m/s",   "m/s^2",
                                       "N", "N/m", "N/m^2", "N/m^3", "N m",   "1/s",     "1/s^2", "1/m",
                                       "T", "T/m", "A/m",   "W",     "N s/m", "N s/m^2", "V",     "C"};

} // namespace

std::optional<Unit> parse_unit(std::string_view text) {
    Unit unit;
    bool below = false, any = false;
    for (std::size_t i = 0; i < text.size();) {
        const char c = text[i];
        if (c == ' ' || c == '*') {
            ++i;
            continue;
        }
        if (c == '/') {
            if (!any || below) return std::nullopt; // "N/m/s" is ambiguous
            below = true;
            any = false;
            ++i;
            continue;
        }
        std::size_t end = i;
        while (end < text.size() && std::isalpha(static_cast<unsigned char>(text[end]))) ++end;
        if (end == i) ++end; // "1", "-"
        const Named* found = nullptr;
        for (const Named& n : named)
            if (n.name == text.substr(i, end - i)) found = &n;
        if (!found) return std::nullopt;
        int exponent = 1;
        if (end < text.size() && text[end] == '^') {
            const auto read = std::from_chars(text.data() + end + 1, text.data() + text.size(), exponent);
            if (read.ec != std::errc()) return std::nullopt;
            end = to_index(read.ptr - text.data());
        }
        unit = unit * found->unit.raised(below ? -exponent : exponent);
        any = true;
        i = end;
    }
    return any ? std::optional(unit) : std::nullopt;
}

std::string unit_text(const Unit& unit) {
    if (unit.pure()) return "a pure number";
    for (const std::string_view text : common)
        if (parse_unit(text) == unit) return std::string(text);
    std::string above, below;
    for (std::size_t i = 0; i < unit.power.size(); ++i) {
        const double p = unit.power[i], size = std::abs(p);
        if (size < 1e-9) continue;
        std::string& side = p > 0 ? above : below;
        side += (side.empty() ? "" : " ") + std::string(named[i].name);
        if (size != 1) side += fmt::format("^{:g}", size);
    }
    if (above.empty()) above = "1";
    return below.empty() ? above : above + "/" + (below.find(' ') == std::string::npos ? below : "(" + below + ")");
}

} // namespace skein
