// Tables of a scene about external loads and damping.
#pragma once

#include "loads/load_spec.hpp"

#include <nlohmann/json_fwd.hpp>

#include <vector>

namespace skein {

struct CoreTables;

struct LoadTables {
    std::vector<LoadSpec> loads;
    std::vector<DampingSpec> damping;

    template <class Scene, class F> static void visit_tables(Scene& scene, F&& f) {
        f("load", scene.loads);
        f("damping", scene.damping);
    }
};

/// Writes "auto" in place of the numbers that stand for it. `physics_only`: for what identifies a run.
void tidy_echo(nlohmann::json& table, const LoadSpec& spec, const CoreTables& scene, bool physics_only);

} // namespace skein
