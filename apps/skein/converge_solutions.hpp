// Runs of a study that are solved in place of stepped.
#pragma once

#include "commands.hpp"
#include "studies/convergence_study.hpp"
#include "studies/run_samples.hpp"

#include <string>
#include <vector>

namespace skein {

/// A solution, with what it has beside the files of a run.
struct StudySolution {
    double core_seconds = 0;          ///< without start and output
    std::vector<Quantity> quantities; ///< frequencies, or critical points of a path
};
struct SolvedStudy {
    std::vector<StudySolution> solutions; ///< of the runs to make, with the quantities that all have
    std::vector<std::string> left_out;    ///< names of those that some do not have
};

/// Method that a command line asks for; StudyMethod::steps: it asks for none.
StudyMethod method_of(const ConvergeArguments& arguments);
/// Solves and writes all runs of a study below `out`. Throws NumericalError where one has no solution. Collective.
SolvedStudy solve_runs(const Communicator& comm, const Study& study, const ConvergeArguments& arguments,
                       const std::string& out);

} // namespace skein
