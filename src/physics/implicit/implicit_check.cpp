#include "physics/implicit/implicit_tables.hpp"
#include "physics/scene_spec.hpp"
#include "physics/table_objections.hpp"

#include <fmt/format.h>

namespace skein {

void ImplicitTables::check(const SceneSpec& scene, Objections& objections) {
    const TimeSpec& time = scene.time;
    TableObjections of_time(objections, "time");
    if (time.relax || !is_implicit(time.integrator)) {
        of_time.unused({"tolerance"}, "without an implicit integrator");
        return;
    }
    const auto name = nth(integrator_names, time.integrator);
    of_time.unused({"safety", "e_min", "damping", "force_dt"},
                   fmt::format("with integrator = \"{}\", whose steps stability does not limit", name));
    const bool in_bed = time.integrator == Integrator::implicit_bed;
    if (in_bed) of_time.unused({"tolerance"}, "with integrator = \"implicit_bed\"");
    else if (scene.fluid) of_time.unused({"tolerance"}, "in a fluid, whose steps set the clock");
    else if (time.dt > 0) of_time.unused({"tolerance"}, "with a given 'dt'");
    const auto refuse = [&](bool has, const std::string& table, const std::string& message) {
        if (has) objections.add(table, fmt::format("time.integrator = \"{}\" {}", name, message));
    };
    for (std::size_t i = 0; i < scene.rods.size(); ++i) {
        const RodSpec& rods = scene.rods[i];
        const std::string group = path_of_group(scene, i);
        refuse(rods.material.law == Law::elastica, group + ".material.law",
               "needs a law with an energy, and \"elastica\" has none");
    }
}

} // namespace skein
