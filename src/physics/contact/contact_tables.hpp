// Tables of a scene about contact between rods.
#pragma once

#include "contact/contact_spec.hpp"
#include "skein/core/objections.hpp"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

struct CoreTables;
struct SceneSpec;
class RodGroup;
struct PlanInput;
class PlannedPhysics;

struct ContactTables {
    std::optional<ContactSpec> contact; ///< absent: rods do not interact
    std::vector<ContactPair> contact_pairs;

    template <class Scene, class F> static void visit_tables(Scene& scene, F&& f) {
        f("contact", scene.contact);
        f("contact_pair", scene.contact_pairs);
    }
    /// Objects to contradictions in them.
    static void check(const SceneSpec& scene, Objections& objections);
    /// Adds its plan to those of a scene that has it.
    static void plan(const PlanInput& input, PlannedPhysics& out);
    /// Writes numbers in place of those that stand for "auto".
    static void resolve(SceneSpec& scene, std::span<const RodGroup> groups);
    /// True if a plan needs all rods of files on every rank: how hard rods press follows from all of them.
    static bool needs_all_rods(const SceneSpec& scene);
    static void note_refinement(const SceneSpec& scene, std::vector<std::string>& notes);
    static std::string_view remark(std::string_view table);
};

/// Writes "auto" in place of the numbers that stand for it.
void tidy_echo(nlohmann::json& table, const ContactSpec& spec, const CoreTables& scene, bool physics_only);

/// Writes "auto" in place of the numbers that stand for it.
void tidy_echo(nlohmann::json& table, const ContactPair& spec, const CoreTables& scene, bool physics_only);

} // namespace skein
