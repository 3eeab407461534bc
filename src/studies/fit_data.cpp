#include "studies/fit_data.hpp"

#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "studies/scene_number.hpp"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <string_view>
#include <utility>

namespace skein {

Heading heading_of(const std::string& text) {
    const std::size_t bracket = text.find('[');
    if (bracket == std::string::npos || !text.ends_with(']')) return {text, {}};
    return {text.substr(0, bracket), text.substr(bracket + 1, text.size() - bracket - 2)};
}

void refuse_other_unit(const Heading& given, const std::string& unit) {
    if (given.unit.empty() || given.unit == unit) return;
    throw InputError(fmt::format("the column '{}' is in {} and has to be in {}", given.name, given.unit,
                                 unit.empty() ? "no unit" : unit));
}

namespace {

/// Columns of a table by what they mean.
struct Meaning {
    std::array<std::size_t, 4> shape{SIZE_MAX, SIZE_MAX, SIZE_MAX, SIZE_MAX}; ///< s, x, y, z
    std::vector<std::pair<std::size_t, Heading>> keys, values;
    bool has_s() const { return shape[0] != SIZE_MAX; }
    std::size_t coordinates() const {
        return 3 - static_cast<std::size_t>(std::count(shape.begin() + 1, shape.end(), SIZE_MAX));
    }
    bool has_shape() const { return coordinates() > 0; }
    std::size_t of_place() const { return has_s() ? 3 : coordinates() - 1; }
};
Meaning meaning_of(const CsvTable& data, const SceneSpec& scene) {
    constexpr std::array<std::string_view, 4> names = {"s", "x", "y", "z"};
    Meaning all;
    std::set<std::string> seen;
    for (std::size_t c = 0; c < data.names.size(); ++c) {
        const Heading heading = heading_of(data.names[c]);
        if (heading.name.empty()) throw InputError(fmt::format("column {} of the data has no name", c + 1));
        if (!seen.insert(heading.name).second)
            throw InputError(fmt::format("the data have two columns '{}'", heading.name));
        const auto part = std::find(names.begin(), names.end(), heading.name);
        if (part != names.end()) {
            refuse_other_unit(heading, "m");
            all.shape[static_cast<std::size_t>(part - names.begin())] = c;
        } else if (heading.name.find('.') != std::string::npos) {
            refuse_other_unit(heading, number_at(scene, heading.name).unit);
            all.keys.emplace_back(c, heading);
        } else {
            all.values.emplace_back(c, heading);
        }
    }
    const std::size_t coordinates = all.coordinates();
    if (coordinates == 1 || (all.has_s() && coordinates != 3))
        throw InputError("data of a shape need the columns s, x, y and z, or without s two or three of x, y, z [m]");
    return all;
}

/// Adds the place of a row, if all of it was measured.
void add_place(Experiment& own, const CsvTable& data, const Meaning& meaning, std::size_t row) {
    std::array<double, 4> place{};
    for (std::size_t part = 0; part < 4; ++part) {
        place[part] = NAN;
        if (meaning.shape[part] == SIZE_MAX) continue;
        place[part] = data.columns[meaning.shape[part]][row];
        if (std::isnan(place[part])) return;
    }
    own.of_place = meaning.of_place();
    own.places.push_back({place[0], {place[1], place[2], place[3]}});
}

Vec3d place_at(double s, const RodGroup& group, const Slot<1>* slot) {
    double left = s, length = 0;
    for (int k = 0; k < group.elements(); ++k) length += nth(group.element, k).rest_length;
    if (!(s >= -1e-9 * length && s <= (1 + 1e-9) * length))
        throw InputError(fmt::format("s = {:g} m of the data is no place of the rod, which is {:g} m long: s is "
                                     "arc length from its start, undeformed",
                                     s, length));
    int k = 0;
    while (k + 1 < group.elements() && left > nth(group.element, k).rest_length)
        left -= nth(group.element, k++).rest_length;
    const double share = left * nth(group.element, k).inv_rest_length;
    return (1 - share) * lane(slot[k].position, 0) + share * lane(slot[k + 1].position, 0);
}

/// Distances of a measured place from the nearest one of the rod, in the coordinates that are known: across the
/// tangent there, so that errors along the rod count for nothing.
void add_distances(const Vec3d& place, const RodGroup& group, const Slot<1>* slot, std::vector<double>& all) {
    std::array<int, 3> known{};
    int count = 0;
    const std::array<double, 3> parts = {place.x, place.y, place.z};
    for (int c = 0; c < 3; ++c)
        if (!std::isnan(parts[static_cast<std::size_t>(c)])) known[static_cast<std::size_t>(count++)] = c;
    const auto seen = [&](const Vec3d& x) {
        const std::array<double, 3> all_of = {x.x, x.y, x.z};
        Eigen::Vector3d in = Eigen::Vector3d::Zero();
        for (int c = 0; c < count; ++c) in[c] = all_of[static_cast<std::size_t>(known[static_cast<std::size_t>(c)])];
        return in;
    };
    const Eigen::Vector3d from = seen(place);
    Eigen::Vector3d away = Eigen::Vector3d::Constant(HUGE_VAL), tangent = Eigen::Vector3d::UnitX();
    for (int k = 0; k < group.elements(); ++k) {
        const Eigen::Vector3d at = seen(lane(slot[k].position, 0)), edge = seen(lane(slot[k + 1].position, 0)) - at;
        if (edge.squaredNorm() == 0) continue;
        const double share = std::clamp((from - at).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
        const Eigen::Vector3d gap = at + share * edge - from;
        if (!(gap.squaredNorm() < away.squaredNorm())) continue;
        away = gap;
        tangent = edge.normalized();
    }
    if (count == 2) {
        all.push_back(away[1] * tangent[0] - away[0] * tangent[1]);
        return;
    }
    Eigen::Index least = 0;
    tangent.cwiseAbs().minCoeff(&least);
    const Eigen::Vector3d across = tangent.cross(Eigen::Vector3d::Unit(least)).normalized();
    all.push_back(away.dot(across));
    all.push_back(away.dot(tangent.cross(across)));
}

} // namespace

std::vector<Experiment> experiments_of(const CsvTable& data, const SceneSpec& scene) {
    if (data.columns.empty() || data.columns.front().empty())
        throw InputError("the data have no rows: a line of names is followed by rows of numbers");
    const Meaning meaning = meaning_of(data, scene);
    std::vector<Experiment> all;
    std::map<std::vector<std::string>, std::size_t> known;
    for (std::size_t row = 0; row < data.columns.front().size(); ++row) {
        std::vector<std::string> keys;
        for (const auto& [c, heading] : meaning.keys) {
            if (!std::isfinite(data.columns[c][row]))
                throw InputError(fmt::format("row {} of the data has no '{}'", row + 1, heading.name));
            keys.push_back(fmt::format("{}={:.17g}", heading.name, data.columns[c][row]));
        }
        const auto [at, fresh] = known.try_emplace(keys, all.size());
        if (fresh) all.push_back({.overrides = keys});
        Experiment& own = all[at->second];
        for (const auto& [c, heading] : meaning.values)
            if (!std::isnan(data.columns[c][row])) own.values.push_back({heading, data.columns[c][row]});
        if (meaning.has_shape()) add_place(own, data, meaning, row);
    }
    return all;
}

Unknown measured_values(const Experiment& experiment) {
    Unknown all(static_cast<Eigen::Index>(experiment.size()));
    Eigen::Index row = 0;
    for (const MeasuredPlace& place : experiment.places) {
        const Eigen::Index next = row + static_cast<Eigen::Index>(experiment.of_place);
        for (const double part : {place.place.x, place.place.y, place.place.z})
            if (row < next && !std::isnan(part)) all[row++] = part;
    }
    for (const MeasuredValue& value : experiment.values) all[row++] = value.value;
    return all;
}

Unknown target_of(const Experiment& experiment) {
    Unknown all = measured_values(experiment);
    if (!experiment.places.empty() && std::isnan(experiment.places.front().s))
        all.head(static_cast<Eigen::Index>(experiment.of_places())).setZero();
    return all;
}

Unknown values_of_places(const Experiment& experiment, const RodGroup& group, const Slot<1>* slot) {
    std::vector<double> all;
    for (const MeasuredPlace& place : experiment.places) {
        if (std::isnan(place.s)) {
            add_distances(place.place, group, slot, all);
            continue;
        }
        const Vec3d x = place_at(place.s, group, slot);
        all.insert(all.end(), {x.x, x.y, x.z});
    }
    return Eigen::Map<const Unknown>(all.data(), static_cast<Eigen::Index>(all.size()));
}

} // namespace skein
