#include "physics/group_names.hpp"
#include "physics/loads/loads_with_formulas.hpp"
#include "physics/table_objections.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

namespace skein {

namespace {

void check_damping(const Damping& d, const std::vector<const RodSpec*>& groups, Integrator integrator,
                   Objections& objections) {
    if (d.kind == DampingKind::legacy || d.kind == DampingKind::laplacian)
        object_to_rigid_bodies(fmt::format("a damping of kind \"{}\"", nth(damping_names, d.kind)), groups, objections);
    const std::string where = fmt::format("for a damping of kind \"{}\"", nth(damping_names, d.kind));
    if (d.kind == DampingKind::laplacian) {
        objections.unused({"translational", "rotational"}, where);
        if (d.order == 0) objections.add("", fmt::format("'order', at least 1, is needed {}", where));
        if (!objections.given("rate"))
            objections.add(
                "rate",
                fmt::format("'rate' [1/s] is needed {}: that of motion which alternates from node to node", where));
        if (kicks_backwards(integrator))
            objections.add("kind",
                           "a damping of kind \"laplacian\" needs integrator = \"verlet\": the kicks of \"pefrl\" go "
                           "backwards too");
        return;
    }
    objections.unused({"order"}, where);
    if (d.kind == DampingKind::physical) {
        objections.unused({"rate"}, where);
        if (!objections.given("translational") && !objections.given("rotational"))
            objections.add("translational",
                           fmt::format("'translational' [kg/s] or 'rotational' [kg m^2/s] is needed {}", where));
        return;
    }
    objections.unused({"translational", "rotational"}, where);
    if (!objections.given("rate")) objections.add("rate", fmt::format("'rate' [1/s] is needed {}", where));
}

} // namespace

void LoadTables::check(const SceneSpec& scene, Objections& objections) {
    const std::vector<Load> loads = loads_with_formulas(scene);
    for (std::size_t i = 0; i < loads.size(); ++i) {
        TableObjections table(objections, fmt::format("load.{}", i));
        const auto groups = acted_on(scene, scene.loads[i].rods, table);
        loads[i].check(groups, table);
    }
    for (std::size_t i = 0; i < scene.damping.size(); ++i) {
        TableObjections table(objections, fmt::format("damping.{}", i));
        check_damping(scene.damping[i].damping, acted_on(scene, scene.damping[i].rods, table), scene.time.integrator,
                      table);
    }
}

} // namespace skein
