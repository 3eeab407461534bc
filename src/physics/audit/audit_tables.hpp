// Energy audit of a scene: a key of [output], no table.
#pragma once

#include "skein/core/objections.hpp"

namespace skein {

struct RodSpec;
struct SceneSpec;
struct PlanInput;
class PlannedPhysics;

struct AuditTables {
    template <class Scene, class F> static void visit_tables(Scene&, F&&) {}
    static void check(const SceneSpec& scene, Objections& objections);
    /// See PhysicsTables.
    static bool look_at_whole_rods(const SceneSpec& scene, const RodSpec& rods);
    /// Adds its plan to those of a scene that has it.
    static void plan(const PlanInput& input, PlannedPhysics& out);
};

} // namespace skein
