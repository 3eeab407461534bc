// Names of columns of the time series by format, so that a run which began with an earlier program resumes. A file
// bears no number of its format: the names in its header tell it.
#pragma once

#include <string>
#include <string_view>

namespace skein {

/// The format of observables.csv; a new one wherever a column gets another name. Summaries have it beside the
/// observables of the end. 2: contact_rubbed, contact_damped, wall_rubbed, wall_damped, deepest_overlap and renewals
/// got the names that they have now.
inline constexpr int series_format = 2;

/// The header of a series in the names of the format before; the same header where none of its columns has been
/// renamed.
std::string earlier_header(std::string_view header);

} // namespace skein
