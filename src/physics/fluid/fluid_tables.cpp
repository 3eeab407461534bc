#include "physics/fluid/fluid_tables.hpp"

#include "physics/scene_spec.hpp"

#include <nlohmann/json.hpp>

namespace skein {

/// Any ranks have the same results, and without rods neither expected speeds nor slips decide steps.
void tidy_echo(nlohmann::json& table, const FluidSpec&, const CoreTables& scene, bool physics_only) {
    if (!physics_only) return;
    table.erase("ranks_across");
    if (!scene.rods.empty()) return;
    table.erase("expected_speed");
    table.erase("largest_slip");
}

} // namespace skein
