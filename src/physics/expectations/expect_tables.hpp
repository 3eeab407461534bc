// Expected values in a scene: they decide nothing in a run.
#pragma once

#include "io/expect_spec.hpp"
#include "skein/core/objections.hpp"

#include <vector>

namespace skein {

struct SceneSpec;
struct PlanInput;
class PlannedPhysics;

struct ExpectTables {
    std::vector<ExpectSpec> expected;

    template <class Scene, class F> static void visit_tables(Scene& scene, F&& f) { f("expect", scene.expected); }
    /// Objects to contradictions in them.
    static void check(const SceneSpec& scene, Objections& objections);
    /// Adds nothing.
    static void plan(const PlanInput&, PlannedPhysics&) {}
};

} // namespace skein
