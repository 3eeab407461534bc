#include "slope_tables.hpp"

#include "io/files.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

namespace skein {

namespace {

constexpr const char* points_name = "slopes.csv";
constexpr const char* critical_name = "critical_slopes.csv";

std::string with_unit(const std::string& name, const std::string& unit) {
    return unit.empty() ? name : fmt::format("{}[{}]", name, unit);
}

/// Unit of a slope; empty where one of the two is not known.
std::string unit_of_slope(const std::string& of, const std::string& by) {
    if (of.empty() || by.empty()) return {};
    const auto whole = [](const std::string& unit) {
        return unit.find_first_of("/ *") == std::string::npos ? unit : "(" + unit + ")";
    };
    return by == "-" ? of : fmt::format("{}/{}", of == "-" ? "1" : whole(of), whole(by));
}

std::string heading_of_slope(const std::string& of, const std::string& of_unit, const std::string& by,
                             const std::string& by_unit) {
    return with_unit(fmt::format("d({})/d({})", of, by), unit_of_slope(of_unit, by_unit));
}

double number_or_none(const nlohmann::ordered_json& value) {
    return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

} // namespace

SlopeTables::SlopeTables(PathSlopes slopes, const GradientReport& names, const std::string& along,
                         const std::string& unit)
    : slopes_(std::move(slopes)), along_(along), unit_(unit) {
    text_ = "point,branch," + with_unit(along, unit);
    for (const NumberSlopes& number : names.numbers) {
        keys_.push_back(number.key);
        units_.push_back(number.unit);
        for (const std::string& name : names.observables) {
            const std::size_t bracket = name.find('[');
            const std::string of =
                bracket == std::string::npos ? "" : name.substr(bracket + 1, name.size() - bracket - 2);
            text_ += "," + heading_of_slope(name.substr(0, bracket), of, number.key, number.unit);
        }
    }
    text_ += "\n";
}

void SlopeTables::go_on(const std::string& directory, std::size_t points, nlohmann::ordered_json critical) {
    const std::string path = directory + "/" + points_name;
    std::string text = std::filesystem::is_regular_file(path) ? read_file(path) : std::string();
    if (!text.starts_with(text_) ||
        std::count(text.begin(), text.end(), '\n') != static_cast<std::ptrdiff_t>(points) + 1)
        throw IoError(path + ": is not as the path left it, so that it cannot be continued");
    text_ = std::move(text);
    critical_ = std::move(critical);
}

void SlopeTables::add(PathFollower& path, const PathPoint& point, std::size_t number, int branch) {
    const StateSlopes found = slopes_.at(point.value, path.state(), path.friction());
    text_ += fmt::format("{},{},{:.17g}", number, branch, point.value);
    for (const NumberSlopes& one : found.report.numbers)
        for (const double slope : one.slope) text_ += fmt::format(",{:.17g}", slope);
    text_ += "\n";
    const bool limit = point.place == PathPlace::limit;
    if (!limit && point.place != PathPlace::branch) return;
    std::vector<double> slopes(keys_.size(), std::numeric_limits<double>::quiet_NaN());
    if (limit && path.friction().empty())
        slopes = slopes_.of_limit(point.value, path.state(), found, path.load_slope());
    else if (!limit && path.changed_directions() == 1) slopes = slopes_.of_branch(point.value, path.state(), found);
    nlohmann::ordered_json row = {{"point", number},
                                  {"branch", branch},
                                  {"place", nth(path_place_names, point.place)},
                                  {"value", point.value},
                                  {"slopes", nlohmann::ordered_json::object()}};
    for (std::size_t i = 0; i < keys_.size(); ++i)
        row["slopes"][keys_[i]] =
            std::isfinite(slopes[i]) ? nlohmann::ordered_json(slopes[i]) : nlohmann::ordered_json();
    critical_.push_back(std::move(row));
}

std::string SlopeTables::critical_csv() const {
    std::string text = "point,branch,place," + with_unit(along_, unit_);
    for (std::size_t i = 0; i < keys_.size(); ++i) text += "," + heading_of_slope(along_, unit_, keys_[i], units_[i]);
    text += "\n";
    for (const auto& row : critical_) {
        text += fmt::format("{},{},{},{:.17g}", row.at("point").get<std::size_t>(), row.at("branch").get<int>(),
                            row.at("place").get<std::string>(), row.at("value").get<double>());
        for (const std::string& key : keys_) text += fmt::format(",{:.17g}", number_or_none(row.at("slopes").at(key)));
        text += "\n";
    }
    return text;
}

void SlopeTables::write(const std::string& directory) const {
    write_file(directory + "/" + points_name, text_);
    write_file(directory + "/" + critical_name, critical_csv());
}

std::string SlopeTables::to_text() const {
    if (critical_.empty()) return {};
    std::string text = fmt::format("Slopes of {} at limit and branch points, per unit of each number\n", along_);
    for (const auto& row : critical_)
        for (std::size_t i = 0; i < keys_.size(); ++i) {
            const double slope = number_or_none(row.at("slopes").at(keys_[i]));
            text +=
                fmt::format("  {:<8} {:>14.6g}   by {:<40} {}\n", row.at("place").get<std::string>(),
                            row.at("value").get<double>(), keys_[i],
                            std::isfinite(slope) ? fmt::format("{:>14.6g} {}", slope, unit_of_slope(unit_, units_[i]))
                                                 : fmt::format("{:>14}", "none"));
        }
    return text;
}

} // namespace skein
