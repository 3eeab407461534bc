// Distance of a run from the limit of many elements and short steps, by runs of other elements and steps. Pure numbers.
//   u(n, h) = u + a n^-p + b h^q + ...                                     docs/numerics.md, "The error of a run"
// Three numbers of elements, each twice the one before, show p; a run of half the step shows b.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace skein {

/// One quantity as runs have it: [samples][components], the same samples in all.
struct LevelValues {
    std::array<std::span<const double>, 3> space; ///< n, 2 n, 4 n
    std::array<double, 3> dt{};                   ///< of these, s
    std::size_t given = 0;                        ///< which of them is the run whose error is asked for
    std::span<const double> half_step;            ///< the same run with half its step
    int time_order = 2;                           ///< q
    std::size_t components = 1;
    std::int64_t steps = 0; ///< of the longest run: each may add its round-off
};

/// Result of three numbers of elements.
enum class Smoothness {
    exact,  ///< no difference beyond round-off
    second, ///< differences fall as those of order 2
    other,  ///< evenly, at another order
    rough   ///< they do not fall evenly: no Richardson value
};

/// Errors of one quantity. Norms are Euclid's of components and the largest of samples, in its unit.
struct Convergence {
    Smoothness smoothness = Smoothness::exact;
    double order = 0;          ///< observed; NaN where exact, or where differences grow or turn round
    double order_used = 2;     ///< p of the Richardson value
    std::vector<double> limit; ///< Richardson value for many elements and short steps; empty where rough
    double spread = 0;         ///< of the last two, with the most elements
    struct ErrorBar {
        double space = 0, time = 0, total = 0;
    };
    ErrorBar error_bar;        ///< of the run as given; where rough a bound by the spread of runs
    ErrorBar error_bar_at_end; ///< of its last sample
    double remainder; ///< what the Richardson value may be wrong by: its change from the first two to the last two
};

Convergence converge(const LevelValues& levels);

/// Largest distance of two quantities.
double distance(std::span<const double> a, std::span<const double> b, std::size_t components);
/// Largest distance of a quantity from its first sample.
double range_of(std::span<const double> values, std::size_t components);

/// Errors of one quantity over its range, as error bars have them at (n, h).
struct ErrorModel {
    double space = 0, space_order = 2, time = 0, time_order = 2;
    /// At n' = times n and h'.
    double at(double times, double dt_share) const;
};

/// Cost of runs, by their elements and steps.
struct CostModel {
    struct Level {
        double elements, dt_limit, core_seconds_per_step; ///< of the largest group; s; s
    };
    std::vector<Level> levels; ///< by rising elements
    double dt_limit(double elements) const;
    double core_seconds_per_step(double elements) const;
};

struct Choice {
    long elements = 0;
    double dt = 0, core_seconds = 0;
};

/// Cheapest numbers of elements, of the group with the most, and step whose errors all stay below `tolerance`;
/// `elements` and `dt` are those of the models. Between 2 and 64 times as many elements; none where these do not do.
/// `duration`: s.
std::optional<Choice> cheapest(std::span<const ErrorModel> models, double tolerance, long elements, double dt,
                               const CostModel& cost, double duration);

} // namespace skein
