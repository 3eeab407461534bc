// Tables of a scene about external loads and damping.
#pragma once

#include "loads/load_spec.hpp"
#include "skein/core/objections.hpp"
#include "time/stage_spec.hpp"

#include <nlohmann/json_fwd.hpp>

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

struct CoreTables;
struct RodSpec;
struct SceneSpec;
class RodGroup;
struct PlanInput;
class PlannedPhysics;
struct Refinement;

struct LoadTables {
    std::vector<LoadSpec> loads;
    std::vector<DampingSpec> damping;

    template <class Scene, class F> static void visit_tables(Scene& scene, F&& f) {
        f("load", scene.loads);
        f("damping", scene.damping);
    }
    /// Objects to contradictions in them.
    static void check(const SceneSpec& scene, Objections& objections);
    /// See PhysicsTables.
    static bool look_at_whole_rods(const SceneSpec& scene, const RodSpec& rods);
    /// Adds its plan to those of a scene that has it.
    static void plan(const PlanInput& input, PlannedPhysics& out);
    /// Writes numbers in place of those that stand for "auto".
    static void resolve(SceneSpec& scene, std::span<const RodGroup> groups);
    static void refine(SceneSpec& out, const SceneSpec& scene, const Refinement& by);
    static void note_refinement(const SceneSpec& scene, std::vector<std::string>& notes);
    static std::string_view remark(std::string_view table);
};

/// A load rises from the begin of its first stage on. True where it acts.
bool stays_in_stage(LoadSpec& load, const ActingStages& acting);

/// Writes "auto" in place of the numbers that stand for it.
void tidy_echo(nlohmann::json& table, const LoadSpec& spec, const CoreTables& scene, bool physics_only);

} // namespace skein
