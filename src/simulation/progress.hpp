// The line that tells how a run is doing: on a terminal one line, rewritten; in a log a line now and then.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// "3 min 05 s"
std::string clock_text(double seconds);

/// "42.0 % done"; of a run that has gone further than it is now to go, how much further.
std::string share_done(std::int64_t step, std::int64_t steps);

/// A bar where standard output is a terminal and the process was not started by an MPI launcher, which gives its first
/// process a terminal of its own even where all goes into a log.
enum class ProgressStyle { automatic, bar, lines };
bool under_launcher();

/// Places of columns among those of the series, by name without unit, as a key of the scene lists them. Throws
/// InputError naming the key and all columns where there is no such one.
std::vector<std::size_t> columns_of(std::string_view key, std::span<const std::string> wanted,
                                    std::span<const std::string> all);

/// When a log gets its lines: 2 s apart at first, then each time the run has become 2 % older, ten minutes apart at
/// most. s of wall time between a line and the next.
double seconds_between_lines(double elapsed);

/// A run that is one of several, made one after the other.
struct PlaceAmongRuns {
    std::string name;   ///< what the line begins with
    double to_come = 0; ///< predicted cost of the runs after it, over its own
};

class Progress {
public:
    Progress(bool shown, ProgressStyle style, std::int64_t first_step, std::int64_t last_step, double dt,
             double elements, std::vector<std::string> columns, std::optional<PlaceAmongRuns> place = {});
    /// True if a line of this step would be shown now.
    bool due(std::int64_t step) const;
    /// `values`: of the columns at this step; empty where they are not known. `more`: put behind.
    void show(std::int64_t step, std::span<const double> values, std::string_view more = {});
    void finish();

private:
    bool shown_, bar_, open_ = false, told_ = false;
    std::int64_t first_, last_;
    double dt_, elements_, started_, last_shown_;
    std::vector<std::string> columns_;
    std::optional<PlaceAmongRuns> place_;
    std::string values_; ///< as last known
};

} // namespace skein
