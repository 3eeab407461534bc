// Slopes of observables by the unknowns, in closed form, for adjoint solutions.                       theory.md (110)
#pragma once

#include "equilibrium/static_solution.hpp"
#include "studies/scene_family.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace skein {

/// Slope of the observable with this column name by the unknowns at rest. None of those without one: extremes, strains,
/// optional sets, and figures of interactions. `time`: of ends, s.
std::optional<Unknown> slope_by_unknowns(const StaticCase& one, const StaticState& state, const std::string& name,
                                         double time);

/// True of a number of contacts, which has no slope: the weights of pairs that it sums are rounded.
bool is_count(std::string_view name);

} // namespace skein
