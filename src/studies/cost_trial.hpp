// Time of the steps of a scene with contacts, from some that are made and timed. What a contact costs depends on how
// many pairs are near and on how fast these change, which passes and counts of rods do not tell.
#pragma once

#include "physics/scene_spec.hpp"
#include "plan/plan.hpp"

#include <string>
#include <vector>

namespace skein {

/// True of a plan whose rods touch, on one rank, with no fluid beside them, and for which there is memory here.
bool cost_is_measured(const Plan& plan);

class World;

/// Pairs per element that have yet to touch until each element touches one other; 0 where half of them do, and where
/// nothing presses them together.
double missing_pairs(const World& world);

/// Replaces what the plan predicts by a measurement. `directory`: of results, whose newest checkpoint the steps go on
/// from; empty: the scene's start. A bed that has yet to form gets a range, up to where each element touches one other.
/// Steps on this process alone, after MPI has begun.
void measure_cost(Plan& plan, const SceneSpec& scene, std::vector<RodGroup> groups, const std::string& directory);

} // namespace skein
