// Slopes of observables at an equilibrium by numbers of the scene.                             theory.md (104), (110)
//   all observables       one solution for each number
//   some of them          one adjoint solution for each observable
#pragma once

#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "studies/scene_family.hpp"
#include "studies/static_slopes.hpp"

#include <string>
#include <vector>

namespace skein {

/// A number, with the slopes of the observables by it.
struct NumberSlopes {
    std::string key, unit;
    double value = 0;
    std::vector<double> slope; ///< by observable
    bool slips = false;        ///< contacts slip as the number goes to one side: these mean nothing
    bool jumps = false;        ///< loads jump at the number, or have another slope to each side: these mean nothing
};

struct GradientReport {
    std::vector<std::string> observables; ///< with units, as in observables.csv
    std::vector<double> value;            ///< of the observables
    std::vector<NumberSlopes> numbers;
    bool rubs = false;       ///< friction acts: its springs hold where they are
    std::size_t adjoint = 0; ///< adjoint solutions, each for an observable
    double seconds = 0;
};

struct GradientOptions {
    std::vector<std::string> keys;      ///< paths of the numbers
    std::vector<std::string> of;        ///< observables, with or without units; none: all
    double time = 0;                    ///< of loads and ends, s
    const BegunBodies* begun = nullptr; ///< from which the equilibrium is looked for; null: the scene's start
};

/// Slopes in a state at rest, with what they are made of.
struct StateSlopes {
    GradientReport report;
    std::vector<Unknown> loads; ///< their slopes by each number, where bodies stay
    bool regular = true;        ///< false where the stiffness is singular to working precision: slopes mean nothing
};
StateSlopes slopes_in(const Communicator& comm, const Threads& threads, const Machine& machine, ObservedCase& observed,
                      const StaticState& state, const GradientOptions& options);
/// Observables and numbers that are asked for, without values and slopes. Throws InputError where there are none of
/// these names, or where a number cannot be varied.
GradientReport names_of(ObservedCase& observed, const Machine& machine, const GradientOptions& options);

/// Throws NumericalError where the scene has no equilibrium.
GradientReport gradients(const Communicator& comm, const Threads& threads, const Machine& machine,
                         const SceneText& text, const GradientOptions& options);
std::string to_text(const GradientReport& report);

} // namespace skein
