// Checks and plan of what "auto" chooses for rods: keys of [[rods]], no table of its own.
#pragma once

#include "skein/core/objections.hpp"

#include <span>

namespace skein {

struct RodSpec;
struct SceneSpec;
struct PlanInput;
class PlannedPhysics;
class RodGroup;

struct RodTables {
    template <class Scene, class F> static void visit_tables(Scene&, F&&) {}
    /// Objects to rotary inertia by "auto" where that inertia is the physics.
    static void check(const SceneSpec& scene, Objections& objections);
    /// See PhysicsTables.
    static bool look_at_whole_rods(const SceneSpec& scene, const RodSpec& rods);
    /// Adds the plan of rotary inertia, which names the gain of "auto" too.
    static void plan(const PlanInput& input, PlannedPhysics& out);
    /// Writes numbers in place of those that stand for "auto".
    static void resolve(SceneSpec& scene, std::span<const RodGroup> groups);
};

} // namespace skein
