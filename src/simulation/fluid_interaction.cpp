#include "simulation/fluid_interaction.hpp"

#include "fluid/start_velocity.hpp"
#include "skein/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr double most_parts = 1e5; ///< of a step

std::unique_ptr<FlowSolver> make_flow(const InteractionParts& parts) {
    const auto make = kernels(parts.plan.machine.lanes).make_flow;
    if (!make)
        throw InputError("the scene has a [fluid], and this program was built without the solver for it: build with "
                         "-DSKEIN_FLUID=ON, which needs FFTW (Debian: libfftw3-dev)");
    return make(parts.comm, parts.threads, parts.plan.fluid->constants);
}

} // namespace

FluidInteraction::FluidInteraction(const InteractionParts& parts)
    : comm_(parts.comm), threads_(parts.threads), plan_(*parts.plan.fluid), flow_(make_flow(parts)) {
    if (!plan_.obstacles.empty()) {
        obstacles_ = std::make_unique<ObstacleForcing>(comm_, threads_, plan_.constants.grid, plan_.forcing, plan_.obstacles);
        flow_->set_forcing(&obstacles_->forcing());
    }
    const Vec3d inflow = plan_.constants.inflow;
    if (plan_.velocity_formula.empty()) flow_->set_velocity([&](const Vec3d&) { return inflow; });
    else flow_->set_velocity(VelocityRow(StartVelocity(plan_.velocity_formula, plan_.names)));
}

void FluidInteraction::drive(const Step& step, Timers& timers) {
    const auto timing = timers.time(Phase::fluid);
    if (!failure_.empty()) return;
    const double limit = flow_->step_limit(plan_.courant); // the same on all ranks
    if (!(step.dt / limit < most_parts)) {
        failure_ =
            fmt::format("the velocity or the viscosity of the fluid leaves steps of {:.3g} s: {:.3g} of them for a step of the "
                        "run, more than {:g}",
                        limit, step.dt / limit, most_parts);
        return;
    }
    if (obstacles_) obstacles_->begin_interval(step.time - step.dt), to_ = step.time;
    try {
        steps_ += flow_->step_within(step.time - step.dt, step.dt, plan_.courant);
    } catch (const NumericalError& error) { // on all ranks
        failure_ = error.what();
    }
}

std::string FluidInteraction::invalid() const {
    if (!failure_.empty()) return failure_;
    double speed = 0;
    for (const FlowFigures& plane : flow_->figures())
        speed = std::isfinite(plane.kinetic_energy) ? std::max(speed, plane.speed) : plane.kinetic_energy;
    return std::isfinite(speed) ? std::string()
                                : std::string("the velocity of the fluid is not finite: its step is too long for what drives it; a "
                                              "smaller fluid.courant or time.dt would do");
}

std::vector<Figure> FluidInteraction::figures(double) const {
    using Of = Figure::Of;
    const std::vector<FlowFigures> planes = flow_->figures();
    const auto terms = [&](auto&& of) {
        std::vector<double> all;
        for (const FlowFigures& plane : planes) all.push_back(of(plane));
        return all;
    };
    const auto largest = [&](double FlowFigures::*of) {
        double most = 0;
        for (const FlowFigures& plane : planes) most = std::max(most, plane.*of);
        return std::vector{most};
    };
    std::vector<Figure> all{{"fluid_energy[J]", Of::sum, terms([](const FlowFigures& f) { return f.kinetic_energy; })},
                            {"fluid_dissipation[W]", Of::sum, terms([](const FlowFigures& f) { return f.dissipation; })},
                            {"fluid_enstrophy[m^3/s^2]", Of::sum, terms([](const FlowFigures& f) { return f.enstrophy; })},
                            {"fluid_momentum_x[kg m/s]", Of::sum, terms([](const FlowFigures& f) { return f.momentum.x; })},
                            {"fluid_momentum_y[kg m/s]", Of::sum, terms([](const FlowFigures& f) { return f.momentum.y; })},
                            {"fluid_momentum_z[kg m/s]", Of::sum, terms([](const FlowFigures& f) { return f.momentum.z; })},
                            {"fluid_max_divergence[1/s]", Of::largest, largest(&FlowFigures::divergence)},
                            {"fluid_max_speed[m/s]", Of::largest, largest(&FlowFigures::speed)},
                            {"fluid_steps[-]", Of::same, {static_cast<double>(steps_)}}};
    if (!obstacles_) return all;
    for (std::size_t o = 0; o < plan_.obstacles.size(); ++o) {
        const Vec3d force = obstacles_->force(o, plan_.constants.density, to_);
        const std::string name = plan_.obstacles[o].name + "_force_";
        all.push_back({name + "x[N]", Of::same, {force.x}});
        all.push_back({name + "y[N]", Of::same, {force.y}});
        all.push_back({name + "z[N]", Of::same, {force.z}});
    }
    all.push_back({"slip[m/s]", Of::same, {obstacles_->forcing().slip()}});
    return all;
}

KeptNumbers FluidInteraction::kept() const {
    const FieldLayout layout = flow_->layout();
    const auto state = flow_->state();
    std::vector<double> numbers{static_cast<double>(steps_)};
    if (obstacles_) {
        const std::vector<double> held = obstacles_->forcing().held().kept(comm_);
        numbers.insert(numbers.end(), held.begin(), held.end());
    }
    KeptNumbers kept{.name = kept_name(),
                     .numbers = std::move(numbers),
                     .sums = 0,
                     .columns = state.size() * static_cast<std::size_t>(layout.nx * layout.ny),
                     .rows = {}};
    kept.rows.reserve(kept.columns * static_cast<std::size_t>(layout.nz));
    for (int k = 0; k < layout.nz; ++k)
        for (const std::span<double> field : state)
            for (int j = 0; j < layout.ny; ++j) {
                const auto row = field.begin() + layout.at(0, j, k);
                kept.rows.insert(kept.rows.end(), row, row + layout.nx);
            }
    return kept;
}

void FluidInteraction::recall(const KeptNumbers& kept) {
    const FieldLayout layout = flow_->layout();
    const auto state = flow_->state();
    if (kept.rows.size() != kept.columns * static_cast<std::size_t>(layout.nz) ||
        kept.columns != state.size() * static_cast<std::size_t>(layout.nx * layout.ny))
        throw IoError("a checkpoint holds another fluid than that of the scene");
    steps_ = steps_before_ = static_cast<std::int64_t>(kept.numbers.at(0));
    auto from = kept.rows.begin();
    for (int k = 0; k < layout.nz; ++k)
        for (const std::span<double> field : state)
            for (int j = 0; j < layout.ny; ++j, from += layout.nx) std::copy_n(from, layout.nx, field.begin() + layout.at(0, j, k));
    flow_->refresh();
    if (obstacles_) obstacles_->forcing().recall_held(std::span(kept.numbers).subspan(1));
}

std::uint64_t FluidInteraction::digest() const { // that of the rows of kept(), without a copy of them, and of forces by marker
    const FieldLayout layout = flow_->layout();
    const auto state = flow_->state();
    std::vector<std::uint64_t> hash(static_cast<std::size_t>(layout.nz));
    threads_.for_each(hash.size(), [&](std::size_t k, int) {
        std::uint64_t h = hash_begin(flow_->slab().first + static_cast<std::int64_t>(k));
        for (const std::span<double> field : state)
            for (int j = 0; j < layout.ny; ++j)
                for (const double x : field.subspan(static_cast<std::size_t>(layout.at(0, j, static_cast<int>(k))),
                                                    static_cast<std::size_t>(layout.nx)))
                    h = hash_with(h, x);
        hash[k] = hash_end(h);
    });
    if (obstacles_) {
        const HeldForces& held = obstacles_->forcing().held();
        for (std::size_t m = 0; m < held.forces().size(); ++m) {
            const Vec3d& f = held.forces()[m];
            const double numbers[] = {f.x, f.y, f.z};
            hash.push_back(hash_numbers(held.identities()[m], numbers));
        }
    }
    return std::accumulate(hash.begin(), hash.end(), std::uint64_t{0});
}

double FluidInteraction::cell_steps() const {
    return static_cast<double>(plan_.constants.grid.count()) * static_cast<double>(steps_ - steps_before_);
}

FluidInteraction* fluid_of(const Interactions& all) {
    for (const auto& one : all)
        if (auto* fluid = dynamic_cast<FluidInteraction*>(one.get())) return fluid;
    return nullptr;
}

} // namespace skein
