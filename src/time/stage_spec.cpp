#include "time/stage_spec.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace skein {

namespace {

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

} // namespace

void StageSpec::fields(FieldVisitor& f) {
    f.visit({.name = "name", .unit = "", .text = "name of the stage, for tables and messages", .required = true}, name);
    f.visit({.name = "duration",
             .unit = "s",
             .text = "duration of the stage; 0: it ends by `until`, the last stage with the run",
             .at_least = 0},
            duration);
    f.visit({.name = "until",
             .unit = "",
             .text = "condition that ends the stage: a column of the time series, < or >, and a number in the column's "
                     "unit, such as \"max_speed < 1e-4\""},
            until);
    f.visit({.name = "check_every",
             .unit = "s",
             .text = "interval between checks of `until`; 0: a thousandth of the run's duration",
             .at_least = 0},
            check_every);
    f.visit({.name = "change",
             .unit = "",
             .text = "keys that change at the start of the stage, each \"path=value\" as for --set"},
            change);
}

bool acts_in(const std::vector<std::string>& stages, const StageSpec& stage) {
    return stages.empty() || std::find(stages.begin(), stages.end(), stage.name) != stages.end();
}

std::optional<StageEnd> stage_end(std::string_view text) {
    const std::size_t at = text.find_first_of("<>");
    if (at == std::string_view::npos) return std::nullopt;
    StageEnd end{std::string(trimmed(text.substr(0, at))), text[at] == '>', 0};
    const std::string_view number = trimmed(text.substr(at + 1));
    const auto [rest, error] = std::from_chars(number.data(), number.data() + number.size(), end.number);
    if (end.column.empty() || error != std::errc{} || rest != number.data() + number.size() ||
        !std::isfinite(end.number))
        return std::nullopt;
    return end;
}

} // namespace skein
