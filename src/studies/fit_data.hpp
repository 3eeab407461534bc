// Measured values that a scene is fitted to: rows of a table by the keys with which they were measured, and the values
// of a rod at rest that are compared with them.
#pragma once

#include "io/csv_table.hpp"
#include "physics/scene_spec.hpp"
#include "skein/rod/rod_group.hpp"
#include "studies/static_slopes.hpp"

#include <optional>
#include <string>
#include <vector>

namespace skein {

/// Heading of a column, "load.0.end.2[N]" or without its unit.
struct Heading {
    std::string name, unit;
};
/// A place on the rod that was measured. Without s it is compared with the nearest place of the rod, in the coordinates
/// that are known.
struct MeasuredPlace {
    double s;    ///< NaN: not known
    Vec3d place; ///< NaN: not known
};
struct MeasuredValue {
    Heading heading;
    double value;
};
/// Rows that were measured with the same keys.
struct Experiment {
    std::vector<std::string> overrides;
    SceneSpec scene;
    std::vector<MeasuredPlace> places;
    std::size_t of_place = 3; ///< values of a place: coordinates, or distances across the rod
    std::vector<MeasuredValue> values;
    std::optional<StaticState> state; ///< its last equilibrium
    std::size_t of_places() const { return of_place * places.size(); }
    std::size_t size() const { return of_places() + values.size(); }
};

Heading heading_of(const std::string& text);
/// Throws InputError where a heading has a unit other than this one.
void refuse_other_unit(const Heading& given, const std::string& unit);

/// Experiments of a table. Throws InputError, naming row or column.
std::vector<Experiment> experiments_of(const CsvTable& data, const SceneSpec& scene);

/// Values of an experiment, places first.
Unknown measured_values(const Experiment& experiment);
/// Values that those at rest are compared with: distances of places without s are none.
Unknown target_of(const Experiment& experiment);
/// Values of a rod at rest beside the measured places: its places at their s, or its distances from them.
Unknown values_of_places(const Experiment& experiment, const RodGroup& group, const Slot<1>* slot);

} // namespace skein
