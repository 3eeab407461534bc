#include "scene/fluid_plan_text.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace skein {

std::string fluid_text(const FluidPlan& fluid) {
    const FlowConstants& c = fluid.constants;
    const auto bound = [&](std::size_t d) { return fluid_boundary_names[static_cast<std::size_t>(c.grid.boundary[d])]; };
    return fmt::format("{} x {} x {} cells of {:.4g} m, {} / {} / {}, {:.4g} kg/m^3, {:.4g} Pa s; {}, Courant number {:g}",
                       c.grid.cells[0], c.grid.cells[1], c.grid.cells[2], c.grid.h, bound(0), bound(1), bound(2), c.density,
                       c.density * c.kinematic_viscosity, flow_scheme_names[static_cast<std::size_t>(c.scheme)], fluid.courant);
}

std::string obstacle_text(const Obstacle& o, const FluidPlan& fluid) {
    const double h = fluid.constants.grid.h;
    return fmt::format("'{}', {} of {:.3g} cells, {} markers{}; {} sweeps", o.name,
                       obstacle_names[static_cast<std::size_t>(o.kind)], 2 * o.radius / h, o.markers(fluid.constants.grid).size(),
                       o.moves() ? ", moves" : "", fluid.forcing.sweeps);
}

nlohmann::ordered_json fluid_json(const FluidPlan& fluid) {
    const FlowConstants& c = fluid.constants;
    nlohmann::ordered_json bounds = nlohmann::ordered_json::array();
    for (const FluidBoundary b : c.grid.boundary) bounds.push_back(fluid_boundary_names[static_cast<std::size_t>(b)]);
    return {{"cells", c.grid.cells},
            {"spacing", c.grid.h},
            {"boundaries", bounds},
            {"density", c.density},
            {"kinematic_viscosity", c.kinematic_viscosity},
            {"scheme", flow_scheme_names[static_cast<std::size_t>(c.scheme)]},
            {"courant", fluid.courant},
            {"bytes_per_cell", FluidPlan::bytes_per_cell}};
}

} // namespace skein
