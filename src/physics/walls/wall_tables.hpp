// Tables of a scene about walls.
#pragma once

#include "contact/wall.hpp"
#include "skein/core/objections.hpp"
#include "time/stage_spec.hpp"

#include <nlohmann/json_fwd.hpp>

#include <vector>

namespace skein {

struct CoreTables;
struct SceneSpec;
struct PlanInput;
class PlannedPhysics;

struct WallTables {
    std::vector<Wall> walls;

    template <class Scene, class F> static void visit_tables(Scene& scene, F&& f) { f("wall", scene.walls); }
    /// Objects to contradictions in them.
    static void check(const SceneSpec& scene, Objections& objections);
    /// Adds its plan to those of a scene that has it.
    static void plan(const PlanInput& input, PlannedPhysics& out);
};

/// Writes "auto" in place of the numbers that stand for it.
void tidy_echo(nlohmann::json& table, const Wall& spec, const CoreTables& scene, bool physics_only);

/// A wall stands in its stages, and has a memory of contacts in all of them.
bool stays_in_stage(Wall& wall, const ActingStages& acting);
/// A wall that moves in another way than before goes on from where it is at `time`, s.
void go_on_from(const Wall& before, Wall& wall, double time);

struct KeyChange;
/// True if a state keeps its meaning under a change of a wall's key.
bool state_survives(const Wall& wall, const KeyChange& change);

} // namespace skein
