// Results of a study: errors by observable, and the cheapest numbers for a tolerance.
#pragma once

#include "studies/convergence.hpp"
#include "studies/convergence_study.hpp"
#include "studies/run_samples.hpp"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

struct ObservableError {
    std::string name, unit;
    double range = 0;                        ///< largest distance from the start, in its unit
    bool counts = true;                      ///< towards a tolerance
    double at_end = 0;                       ///< of the run as given: a number, or how far a point has moved
    std::optional<double> richardson;        ///< the same for many elements and short steps
    std::vector<double> end, richardson_end; ///< components
    std::array<double, 4> error{}; ///< of every run against the Richardson value, or the run with the most elements
    Convergence convergence;
};

struct StudyFigures {
    std::array<double, 4> core_seconds{}; ///< of each run, all of it
    std::vector<ObservableError> observables;
    std::vector<std::string> notes;
};

/// `samples`: of the runs of the study. Observables that do not change are left out. Throws IoError where runs do not
/// have the same samples.
StudyFigures figures_of(const Study& study, const std::array<RunSamples, 4>& samples,
                        const std::array<double, 4>& core_seconds);

/// Verdict of `cheapest` on observables that count, or of those named; the observables that cannot be told of by a rule
/// are named.
struct Advice {
    double tolerance = 0;
    std::optional<Choice> choice;
    std::vector<std::string> by, untold;
};
/// Throws InputError where there is no observable of a name.
Advice advice_for(const Study& study, const StudyFigures& figures, double tolerance,
                  std::span<const std::string> names);

} // namespace skein
