// Tables of a scene about a fluid and the bodies in it.
#pragma once

#include "fluid/fluid_probe.hpp"
#include "fluid/fluid_spec.hpp"
#include "immersion/immersion_spec.hpp"
#include "immersion/obstacle.hpp"
#include "io/fluid_output_spec.hpp"
#include "skein/core/objections.hpp"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <vector>

namespace skein {

struct CoreTables;
struct RodSpec;
struct SceneSpec;
struct PlanInput;
class PlannedPhysics;

struct FluidTables {
    std::optional<FluidSpec> fluid;
    ImmersionSpec immersion;
    std::vector<Obstacle> obstacles;
    std::vector<FluidOutputSpec> fluid_outputs;
    std::vector<FluidProbeSpec> fluid_probes;

    template <class Scene, class F> static void visit_tables(Scene& scene, F&& f) {
        f("fluid", scene.fluid);
        f("immersion", scene.immersion, has_immersed(scene));
        f("obstacle", scene.obstacles);
        f("fluid_output", scene.fluid_outputs);
        f("fluid_probe", scene.fluid_probes);
    }
    /// Bodies are in a fluid.
    template <class Scene> static bool has_immersed(const Scene& scene) {
        return scene.fluid && (!scene.obstacles.empty() || !scene.rods.empty());
    }
    /// Objects to contradictions in them.
    static void check(const SceneSpec& scene, Objections& objections);
    /// See PhysicsTables.
    static bool look_at_whole_rods(const SceneSpec& scene, const RodSpec& rods);
    /// Adds its plan to those of a scene that has it.
    static void plan(const PlanInput& input, PlannedPhysics& out);
};

/// Leaves out keys that do not identify a run, if `physics_only`.
void tidy_echo(nlohmann::json& table, const FluidSpec& spec, const CoreTables& scene, bool physics_only);

} // namespace skein
