// Numbers of a scene from measured shapes and curves: least squares over equilibria, with confidence intervals.
//   data      a table (CSV). s, x, y, z: places on a rod, at the arc length s of the undeformed rod; without s: points
//             anywhere along it, in two or three coordinates; names with a dot: keys of the scene that the row was
//             measured with; other names: observables
//   residual  (predicted - measured)/sigma, of points without s their distances across the rod, with one sigma for
//   places, and one for each observable,
//             found from the residuals that are left
//   slopes    of an equilibrium by a number: K v = d residual/dp                                theory.md (104), (105)
//   interval  value +- t sqrt(diag (J^T J)^-1 s^2), s^2 the mean square of the residuals that is left
#pragma once

#include "io/csv_table.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "studies/static_slopes.hpp"

#include <map>
#include <string>
#include <vector>

namespace skein {

struct FitOptions {
    std::vector<std::string> keys;  ///< paths of the numbers to find
    double time = 0;                ///< of loads and ends, s
    bool keep_undetermined = false; ///< what the data do not determine stays as near to the scene as the data allow
    std::string rods;               ///< group whose rod 0 the shape is of; empty: the first
    int most_iterations = 60;
    double tolerance = 1e-9;            ///< of a step over the value
    const BegunBodies* begun = nullptr; ///< from which equilibria are looked for; null: the scene's start
};

struct FittedNumber {
    std::string key, unit;
    double value = 0, half_width = 0; ///< half the width of the interval of 95 %; infinite: not determined
};

/// Residual of the values of one kind: places, or an observable.
struct Misfit {
    std::string of, unit;
    double size = 0; ///< root mean square
};

struct FitReport {
    std::vector<FittedNumber> numbers;
    std::size_t values = 0;      ///< measured
    std::size_t experiments = 0; ///< rows of equal keys
    int iterations = 0;
    std::vector<Misfit> misfits;
    double seconds = 0;
};

/// Throws InputError where the data do not determine the numbers, naming those that only go together.
FitReport fit(const Communicator& comm, const Threads& threads, const Machine& machine, const SceneText& text,
              const CsvTable& data, const FitOptions& options);
std::string to_text(const FitReport& report);
std::string to_csv(const FitReport& report);

} // namespace skein
