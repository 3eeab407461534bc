// Tables of a scene about assemblies and joints.
#pragma once

#include "joints/joint_spec.hpp"
#include "skein/core/objections.hpp"
#include "skein/placement/assembly.hpp"
#include "time/stage_spec.hpp"

#include <nlohmann/json_fwd.hpp>

#include <vector>

namespace skein {

struct CoreTables;
struct SceneSpec;
struct PlanInput;
class PlannedPhysics;

struct JointTables {
    std::vector<AssemblySpec> assemblies;
    std::vector<JointSpec> joints;

    template <class Scene, class F> static void visit_tables(Scene& scene, F&& f) {
        f("assembly", scene.assemblies);
        f("joint", scene.joints);
    }
    /// Objects to contradictions in them.
    static void check(const SceneSpec& scene, Objections& objections);
    /// Adds its plan to those of a scene that has it.
    static void plan(const PlanInput& input, PlannedPhysics& out);
};

/// A joint is made, and lets go, as stages begin. It has its events in all of them, as its memory does.
bool stays_in_stage(JointSpec& joint, const ActingStages& acting);

/// Writes "auto" in place of the numbers that stand for it.
void tidy_echo(nlohmann::json& table, const JointSpec& spec, const CoreTables& scene, bool physics_only);

} // namespace skein
