#include "scene/fluid_plan.hpp"

#include "scene/scene_tables.hpp"

namespace skein {

namespace {

double projections(FlowScheme scheme) { return scheme == FlowScheme::rk3_projected ? 3 : 1; }
double stages(FlowScheme scheme) { return scheme == FlowScheme::adams_bashforth ? 1 : 3; }

} // namespace

double FluidPlan::transposed_bytes(int ranks) const {
    const double mine = static_cast<double>(constants.grid.count()) / ranks;
    return projections(constants.scheme) * 2 * sizeof(double) * mine * (ranks - 1) / ranks;
}

double FluidPlan::ghost_bytes(int ranks) const {
    if (ranks == 1) return 0;
    const auto [nx, ny, nz] = constants.grid.cells;
    const double fields = 3 * stages(constants.scheme) + 2 * projections(constants.scheme);
    return fields * 2 * FieldLayout::ghosts * sizeof(double) * nx * ny;
}

FluidPlan plan_fluid(const SceneSpec& scene) {
    return {.constants = scene.fluid->constants(),
            .courant = scene.fluid->courant,
            .velocity_formula = scene.fluid->velocity_formula,
            .obstacles = scene.obstacles,
            .forcing = scene.immersion.numbers(),
            .names = names_for_formulas(scene)};
}

} // namespace skein
