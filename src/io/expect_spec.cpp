#include "io/expect_spec.hpp"

#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {

void ExpectSpec::fields(FieldVisitor& f) {
    f.visit({.name = "column", .unit = "", .text = "of observables.csv, without its unit", .required = true}, column);
    f.choice({.name = "take",
              .unit = "",
              .text = "end: the number of the last row; largest, least, mean: of all rows from `from` until `until`"},
             take, expect_take_names);
    f.visit({.name = "from", .unit = "s", .text = "of largest, least, mean: first time", .at_least = 0}, from);
    f.visit({.name = "until",
             .unit = "s",
             .text = "of largest, least, mean: last time; 0: the end of the run",
             .at_least = 0},
            until);
    f.visit({.name = "value", .unit = "-", .text = "expected, in the unit of the column", .required = true}, value);
    f.visit({.name = "tolerance",
             .unit = "-",
             .text = "largest difference that is accepted, over `scale`",
             .required = true,
             .above = 0},
            tolerance);
    f.visit({.name = "scale",
             .unit = "-",
             .text = "in the unit of the column; 0: the absolute value of `value`",
             .at_least = 0},
            scale);
    f.visit({.name = "reference",
             .unit = "",
             .text = "origin of the value: a closed form, a publication, an independent solution",
             .required = true},
            reference);
}

double found_in(const CsvTable& series, const ExpectSpec& expected) {
    const auto column_of = [&](std::string_view name) -> const std::vector<double>& {
        for (std::size_t i = 0; i < series.names.size(); ++i)
            if (std::string_view(series.names[i]).substr(0, series.names[i].find('[')) == name)
                return series.columns[i];
        throw InputError(fmt::format("{}: the time series has no column '{}'", expected.source, name));
    };
    const std::vector<double>&time = column_of("time"), &column = column_of(expected.column);
    if (column.empty()) throw InputError(fmt::format("{}: the time series has no rows", expected.source));
    if (expected.take == ExpectTake::end) return column.back();
    std::vector<double> rows;
    const double round = 1e-9 * time.back(); // a row at `from` or `until` itself counts
    for (std::size_t i = 0; i < column.size(); ++i)
        if (time[i] >= expected.from - round && (expected.until == 0 || time[i] <= expected.until + round))
            rows.push_back(column[i]);
    if (rows.empty())
        throw InputError(fmt::format("{}: the time series has no row from {} s until {} s", expected.source,
                                     expected.from, expected.until));
    if (std::any_of(rows.begin(), rows.end(), [](double x) { return std::isnan(x); })) return NAN;
    switch (expected.take) {
    case ExpectTake::largest:
        return *std::max_element(rows.begin(), rows.end());
    case ExpectTake::least:
        return *std::min_element(rows.begin(), rows.end());
    default:
        return std::accumulate(rows.begin(), rows.end(), 0.0) / static_cast<double>(rows.size());
    }
}

} // namespace skein
