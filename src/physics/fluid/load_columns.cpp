#include "physics/fluid/load_columns.hpp"

#include "physics/scene_spec.hpp"
#include "plan/plan_words.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr std::int64_t most_rods = 1000; ///< of output.fluid_forces: 6000 columns

/// Throws InputError where groups have more rods than a table has use for.
void stop_too_many(const SceneSpec& scene, std::span<const RodGroup> groups) {
    std::int64_t rods = 0;
    for (const std::string& name : scene.output.fluid_forces)
        for (const RodGroup& group : groups)
            if (group.name() == name) rods += group.count();
    if (rods <= most_rods) return;
    throw InputError(fmt::format("{}: output.fluid_forces: its groups have {} rods and bodies, which would make {} "
                                 "columns: at most {} may have columns of their own; a [[probe]] with quantity = "
                                 "\"fluid_force\" or \"fluid_couple\" shows a single one",
                                 scene.file, rods, 6 * rods, most_rods));
}

/// Collects columns, and each rod once.
class Collector {
public:
    void add(std::string name, std::size_t group, std::int64_t index, bool couple) {
        const auto [at, added] = number_.try_emplace({group, index}, all_.rods.size());
        if (added) all_.rods.push_back({group, index});
        all_.columns.push_back({std::move(name), at->second, couple});
    }
    SingleLoads take() { return std::move(all_); }

private:
    SingleLoads all_;
    std::map<std::pair<std::size_t, std::int64_t>, std::size_t> number_;
};

} // namespace

SingleLoads single_loads(const SceneSpec& scene, std::span<const RodGroup> groups) {
    stop_too_many(scene, groups);
    Collector all;
    const auto& names = scene.output.fluid_forces;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (std::find(names.begin(), names.end(), groups[g].name()) == names.end()) continue;
        for (std::int64_t i = 0; i < groups[g].count(); ++i)
            for (const bool couple : {false, true})
                all.add(fmt::format("{}_{}_fluid_{}", groups[g].name(), i, couple ? "couple" : "force"), g, i, couple);
    }
    for (const ProbeSpec& probe : scene.probes)
        for (std::size_t g = 0; g < groups.size() && probe.of_fluid(); ++g)
            if (groups[g].name() == probe.of)
                all.add(probe.name, g, probe.number, probe.quantity == ProbeQuantity::fluid_couple);
    return all.take();
}

std::string single_loads_text(const SingleLoads& loads) {
    if (loads.rods.empty()) return {};
    return fmt::format("{} of forces and couples on {}", counted(std::ssize(loads.columns) * 3, "column"),
                       loads.rods.size() == 1 ? "a single rod or body"
                                              : fmt::format("{} single rods and bodies", loads.rods.size()));
}

} // namespace skein
