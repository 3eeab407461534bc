// Probes of a scene: columns of the time series, no physics.
#pragma once

#include "diagnostics/probes.hpp"
#include "skein/core/objections.hpp"

#include <vector>

namespace skein {

struct SceneSpec;
struct PlanInput;
class PlannedPhysics;

struct ProbeTables {
    std::vector<ProbeSpec> probes;

    template <class Scene, class F> static void visit_tables(Scene& scene, F&& f) { f("probe", scene.probes); }
    /// Objects to contradictions in them.
    static void check(const SceneSpec& scene, Objections& objections);
    /// Adds nothing, and throws InputError where a group has fewer rods than a probe counts.
    static void plan(const PlanInput& input, PlannedPhysics& out);
};

} // namespace skein
