// Quantities of a case at rest, and their slopes by numbers of its scene.                            theory.md (104)
//   forward   K v = d residual/dp of a number, then dy/dp = dy/du v + dy/dp at the same u: for all quantities
//   adjoint   K l = dy/du of an observable, then dy/dp = l . d residual/dp + dy/dp: for all numbers
#pragma once

#include "equilibrium/newton.hpp"
#include "equilibrium/static_solution.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "simulation/observation.hpp"
#include "simulation/world.hpp"
#include "studies/scene_family.hpp"
#include "studies/shared_bodies.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace skein {

/// An equilibrium from this state, with friction that has memory, or why there is none. Throws Stopped where a signal
/// ends it.
Equilibrium find_or_stop(StaticSystem& system, StaticState& state, double time);
/// Bodies as a checkpoint has them, with what they remember.
struct BegunBodies {
    SharedBodies bodies;
    std::vector<SavedContact> contacts;
};
/// Bodies of a world on one rank.
BegunBodies begun_bodies(const World& world);
/// Throws InputError where they are not those of the case, or held elsewhere than it places them.
void require_held_as_placed(StaticCase& one, const BegunBodies& begun);

/// Equilibrium from the bodies' places in the scene, or from `begun`; null: the former. Throws NumericalError where
/// there is none.
StaticState equilibrium_of(StaticCase& one, double time, const BegunBodies* begun = nullptr);

/// Throws NumericalError: the stiffness is singular, so that slopes have no value.
[[noreturn]] void refuse_singular();

/// A case whose observables at a time, s, are asked for. Its bodies are made at the first question.
class ObservedCase {
public:
    ObservedCase(const Communicator& comm, const Threads& threads, const StaticCase& at, double time)
        : comm_(&comm), threads_(&threads), at_(&at), time_(time) {}

    /// States from here on stretch springs of friction that are known elsewhere; empty: none acts.
    void take_friction(FrictionMemory known) { friction_ = std::move(known); }

    const StaticCase& at() const { return *at_; }
    /// Columns of observables.csv, with units.
    const std::vector<std::string>& names();
    /// Figures that sum what steps do are not numbers.
    std::vector<double> values(const StaticState& state);

private:
    void make();
    /// Slots of local()[i] among those of all bodies.
    std::span<const Slot<1>> slots_of(std::size_t i, std::span<const Slot<1>> all) const;

    const Communicator* comm_;
    const Threads* threads_;
    const StaticCase* at_;
    double time_;
    FrictionMemory friction_;
    std::unique_ptr<World> world_;
    std::optional<Observation> observation_;
    std::vector<std::string> names_;
};

/// Numbers that a state at rest has: places, then observables.
struct RestQuantity {
    std::function<Unknown(const StaticCase&, const StaticState&)> places; ///< null: none
    std::vector<std::size_t> observables;                                 ///< by their columns

    Unknown at(ObservedCase& observed, const StaticState& state) const;
    /// The same of changes of all observables, where places stay.
    Unknown of_observables(const std::vector<double>& change, Eigen::Index size) const;
};

/// True where friction acts otherwise along a change of the unknowns, which a solution in the state has, than against
/// it, so that the changes to both sides differ by more than a hundredth.                              theory.md (106)
bool slips_along(const Unknown& change, const StaticSolution& solution, StaticSystem& system, const StaticState& state);
/// Throws NumericalError: friction acts otherwise to one side of a number.
[[noreturn]] void refuse_slip(const std::string& key);

/// Slopes of a quantity by the state, along a change of the unknowns.
Unknown slope_along(const Unknown& change, const RestQuantity& quantity, ObservedCase& observed,
                    const StaticState& state);

} // namespace skein
