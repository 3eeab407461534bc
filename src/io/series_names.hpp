// Names of columns of the time series by format, so that runs of earlier programs can resume. The names in the header
// of a file identify its format.
#pragma once

#include <string>
#include <string_view>

namespace skein {

/// Format of observables.csv, which every renaming of a column increases. Summaries state it beside the final
/// observables. Format 2 renamed contact_rubbed, contact_damped, wall_rubbed, wall_damped, deepest_overlap and
/// renewals.
inline constexpr int series_format = 2;

/// Header of a series with the column names of the format before.
std::string earlier_header(std::string_view header);

} // namespace skein
