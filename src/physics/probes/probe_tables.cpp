#include "physics/probes/probe_tables.hpp"

#include "core/nearest.hpp"
#include "physics/group_names.hpp"
#include "physics/plan_input.hpp"
#include "physics/table_objections.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace skein {

void ProbeTables::check(const SceneSpec& scene, Objections& objections) {
    for (std::size_t i = 0; i < scene.probes.size(); ++i) {
        const ProbeSpec& probe = scene.probes[i];
        TableObjections mine(objections, fmt::format("probe.{}", i));
        if (!good_name(probe.name))
            mine.add("name", fmt::format("'name' is \"{}\"; it may have letters, digits, _ and -", probe.name));
        for (std::size_t j = 0; j < i; ++j)
            if (scene.probes[j].name == probe.name)
                mine.add("name", fmt::format("a probe '{}' stands above already", probe.name));
        const RodSpec* group = group_named(scene, probe.of, mine, "of");
        if (group && group->body && probe.strained())
            mine.add("quantity", fmt::format("'{}' is a rigid body, which has no {}", probe.of,
                                             nth(probe_quantity_names, probe.quantity)));
        if (probe.of_fluid()) mine.unused({"at"}, "for a force or couple on a whole rod");
        else if (group && group->body) mine.unused({"at"}, "for a body");
        if (probe.of_fluid() && !scene.fluid)
            mine.add("quantity", fmt::format("a probe of \"{}\" needs rods in a [fluid], and there is none",
                                             nth(probe_quantity_names, probe.quantity)));
    }
}

void ProbeTables::plan(const PlanInput& input, PlannedPhysics&) {
    for (const ProbeSpec& probe : input.scene.probes)
        for (const RodGroup& group : input.groups)
            if (group.name() == probe.of && probe.number >= group.count())
                throw InputError(
                    fmt::format("{}: 'number' of the probe '{}' is {}; the group '{}' has {}, counted from 0",
                                probe.source, probe.name, probe.number, probe.of, group.count()));
}

} // namespace skein
