// Slopes of all observables at an equilibrium by numbers of the scene.
//   K v = d residual/dp,   dy/dp = dy/du v + dy/dp: one factor for all numbers, one solution for each.  theory.md (104)
#pragma once

#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "studies/scene_family.hpp"

#include <string>
#include <vector>

namespace skein {

/// A number, with the slopes of the observables by it.
struct NumberSlopes {
    std::string key, unit;
    double value = 0;
    std::vector<double> slope; ///< by observable
};

struct GradientReport {
    std::vector<std::string> observables; ///< with units, as in observables.csv
    std::vector<double> value;            ///< of the observables
    std::vector<NumberSlopes> numbers;
    double seconds = 0;
};

/// `time`: of loads and ends, s. Throws NumericalError where the scene has no equilibrium.
GradientReport gradients(const Communicator& comm, const Threads& threads, const Machine& machine,
                         const SceneText& text, const std::vector<std::string>& keys, double time);
std::string to_text(const GradientReport& report);

} // namespace skein
