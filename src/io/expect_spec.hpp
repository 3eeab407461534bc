// Expected values of a scene: numbers of the time series beside known ones. `skein expect` compares them.
#pragma once

#include "io/csv_table.hpp"
#include "skein/core/fields.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Number that is taken from a column.
enum class ExpectTake { end, largest, least, mean };
inline constexpr std::string_view expect_take_names[] = {"end", "largest", "least", "mean"};

/// [[expect]]
struct ExpectSpec {
    std::string column; ///< without its unit
    ExpectTake take = ExpectTake::end;
    double from = 0, until = 0; ///< s; until 0: the end of the run
    double value = 0;           ///< in the column's unit
    double tolerance = 0;       ///< over `scale`
    double scale = 0;           ///< in the column's unit; 0: |value|
    std::string reference;      ///< the value's origin
    std::string source;         ///< file:line of the table, for messages

    static constexpr bool output_only = true;

    double allowed() const { return tolerance * (scale > 0 ? scale : value < 0 ? -value : value); }
    void fields(FieldVisitor& f);
};

/// The number of a time series that an [[expect]] is about. Throws InputError where the series has no such column, or
/// no row in those times.
double found_in(const CsvTable& series, const ExpectSpec& expected);

} // namespace skein
