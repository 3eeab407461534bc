#include "physics/fluid/fluid_interaction.hpp"

#include "core/hash.hpp"
#include "core/two_digits.hpp"
#include "fluid/pressure_gain.hpp"
#include "fluid/start_velocity.hpp"
#include "fluid/whole_planes.hpp"
#include "loads/gravity.hpp"
#include "parallel/exact_sum.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "physics/fluid/fluid_pressure.hpp"
#include "physics/fluid/shared_nodes.hpp"
#include "physics/loads/load_plan.hpp"
#include "rod/body_shape.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace skein {

namespace {

constexpr double no_time = -1; ///< of a pressure that belongs to none

/// Acceleration of a group by gravity alone, m/s^2.
ForceBalance::Weight weight_of(const Plan& plan) {
    return [loads = plan.find<LoadPlan>()](std::size_t group, double time) {
        Vec3d all{0, 0, 0};
        for (const std::size_t i : loads->of_group[group])
            if (const auto* gravity = loads->loads[i].get_if<Gravity>())
                all += gravity->ramp.at(time) * gravity->acceleration;
        return all;
    };
}

std::size_t cells_of_plane(const FieldLayout& layout) {
    return static_cast<std::size_t>(layout.nx) * static_cast<std::size_t>(layout.ny);
}

/// body(row of a plane) of a field.
template <class Numbers, class Body>
void for_rows_of(const FieldLayout& layout, const Numbers& field, int k, Body&& body) {
    for (int j = 0; j < layout.ny; ++j)
        body(std::span(field).subspan(static_cast<std::size_t>(layout.at(0, j, k)),
                                      static_cast<std::size_t>(layout.nx)));
}

/// The first face of a box, walls or open, beyond which a place lies.
std::optional<FluidFace> face_beyond(const FluidGrid& box, const Vec3d& place, double rounding) {
    const Vec3d upper = box.upper();
    for (int d = 0; d < 3; ++d) {
        const double x = component_of(place, d), from = component_of(box.lower, d), to = component_of(upper, d);
        if (box.periodic(d)) continue;
        if (x < from - rounding) return FluidFace{d, false, from};
        if (x > to + rounding) return FluidFace{d, true, to};
    }
    return std::nullopt;
}

/// Shares of a step that its stages take.
std::vector<int> shares_of(FlowScheme scheme) {
    const StageParts parts = stage_parts(scheme);
    return {parts.part.begin(), parts.part.begin() + parts.count};
}

std::unique_ptr<FlowSolver> make_flow(const InteractionParts& parts, const FluidPlan& plan) {
    if (const std::string fault = unshared(plan.constants, parts.comm.size()); !fault.empty())
        throw InputError(plan.ranks_across_at.empty() ? fault : plan.ranks_across_at + ": 'ranks_across': " + fault);
    return kernels(parts.plan.machine.lanes).make_flow(parts.comm, parts.threads, plan.constants);
}

} // namespace

FluidInteraction::FluidInteraction(const InteractionParts& parts, const FluidPlan& plan)
    : comm_(parts.comm), threads_(parts.threads), plan_(plan),
      schedule_(plan_.every, shares_of(plan_.constants.scheme)), meshes_(plan_.obstacles),
      flow_(make_flow(parts, plan)), groups_(parts.groups), automatic_dt_(parts.plan.automatic_dt),
      lag_(scheme_of(parts.plan.integrator).lag * parts.plan.dt) {
    const FluidGrid& grid = plan_.constants.grid;
    std::unique_ptr<ImmersedRods> rods;
    if (!groups_.empty())
        rods = std::make_unique<ImmersedRods>(groups_, parts.rods, plan_.kinds, plan_.single_loads.rods);
    if (rods || !plan_.obstacles.empty()) {
        bodies_ = std::make_unique<Immersion>(comm_, threads_, grid, plan_.forcing, plan_.obstacles, std::move(rods),
                                              flow_->pencils().across());
        bodies_->set_lag(lag_);
        if (plan_.measures_power) bodies_->measure_work();
        if (plan_.two_way()) {
            bodies_->set_balance(std::make_unique<ForceBalance>(
                groups_, *bodies_->rods(), parts.around.fluid,
                ForceBalance::Fluid{plan_.constants.density, grid.h * grid.h * grid.h, plan_.passing()},
                weight_of(parts.plan), shared_nodes(parts, plan_)));
        }
        flow_->set_forcing(&bodies_->stage_forcing());
    }
    if (writes_pressure(plan_)) pressure_in_time(*flow_).keep_pressure_gain();
    const Vec3d inflow = plan_.constants.inflow;
    if (plan_.velocity_formula.empty()) flow_->set_velocity([&](const Vec3d&) { return inflow; });
    else flow_->set_velocity(VelocityRow(StartVelocity(plan_.velocity_formula, plan_.names)));
}

void FluidInteraction::rebind(const InteractionParts& parts) { bodies_->rods()->rebind(parts.rods); }

std::int64_t FluidInteraction::next_coupling(std::int64_t done) const {
    return groups_.empty() || !failure_.empty() ? Every::never : schedule_.next(done);
}

template <class F> void FluidInteraction::timed(Timers& timers, F&& f) {
    {
        const auto timing = timers.time(Phase::fluid);
        f();
    }
    if (bodies_) timers.move(Phase::fluid, Phase::markers, bodies_->take_seconds());
}

void FluidInteraction::begin(const Step& first, Timers& timers) {
    if (groups_.empty() || !failure_.empty() || first.before() == begun_) return;
    begun_ = first.before(); // parts of its step begin too
    timed(timers, [&] {
        if (schedule_.part_begins(first.before()) && !choose_part(first)) return;
        if (const auto stage = schedule_.stage_begins(first.before())) begin_stage(*stage, first);
    });
}

void FluidInteraction::begin_again() {
    if (bodies_ && bodies_->balance()) bodies_->balance()->forget_received();
}

void FluidInteraction::end_step(const Step& step, Timers& timers) {
    if (!failure_.empty()) return;
    timed(timers, [&] {
        try {
            if (groups_.empty()) return step_alone(step);
            if (!step.completes) return;
            if (const auto stage = schedule_.stage_ends(step.index)) end_stage(*stage, step);
        } catch (const NumericalError& error) { // on all ranks
            failure_ = error.what();
        }
    });
}

void FluidInteraction::fail_at(double limit, double dt) {
    failure_ = fmt::format(
        "the velocity or the viscosity of the fluid leaves steps of {:.3g} s: {:.3g} of them for {:.3g} s of the "
        "run, more than {:g}",
        limit, dt / limit, dt, most_fluid_steps);
}

void FluidInteraction::fail_with_rods(double limit, double dt) {
    const auto unit = static_cast<double>(schedule_.unit());
    if (automatic_dt_)
        needed_ =
            fmt::format("fluid.expected_speed={:g}", rounded_up(1.5 * plan_.courant * plan_.constants.grid.h / limit));
    else needed_ = fmt::format("time.dt={:g}", rounded_down(limit / (1.5 * unit)));
    failure_ = fmt::format(
        "the fluid or the rods in it move at {:.3g} m/s, which leaves steps of the fluid of {:.3g} s; with {} steps "
        "of rods in each, of {:.3g} s, {:.3g} s is the shortest; {} lets them move at up to {:.3g} m/s",
        speed_, limit, unit, dt, unit * dt, needed_, 1.5 * speed_);
}

std::vector<std::string> FluidInteraction::remedies() const {
    if (!needed_.empty()) return {needed_};
    if (groups_.empty() || !plan_.two_way()) return {};
    const double speed = std::max({plan_.speed.value, plan_.stated, speed_to_expect_, speed_});
    if (!automatic_dt_ || !(speed > 0) || !std::isfinite(speed)) return {};
    return {fmt::format("fluid.expected_speed={:g}", rounded_up(2 * speed))};
}

std::optional<FluidInteraction::SlipFigures> FluidInteraction::slips() const {
    if (!(plan_.largest_slip > 0) || steps_ == steps_before_ || !(speed_ > 0))
        return std::nullopt; // speed: as a step began
    return SlipFigures{slip(), slip() / speed_, largest_share_, plan_.largest_slip};
}

std::string FluidInteraction::warning() const {
    constexpr double large = 2.5; // times what is allowed
    const auto found = slips();
    if (!found || found->share <= large * found->allowed) return {};
    const double wanted = last_length_ * found->allowed / found->share; // s
    const auto unit = static_cast<double>(schedule_.unit());
    return fmt::format(
        "velocities of fluid and rods differ by {:.3g} m/s at the end, {:.2g} of the largest speed, although steps of "
        "the "
        "fluid are as short as they can be: the motion of rods in it is wrong by about as much; {} makes them shorter",
        found->slip, found->share,
        automatic_dt_
            ? fmt::format("fluid.expected_speed = {:g}", rounded_up(plan_.courant * plan_.constants.grid.h / wanted))
            : fmt::format("time.dt = {:g}", rounded_down(wanted / unit)));
}

void FluidInteraction::step_alone(const Step& step) {
    const double limit = flow_->step_limit(plan_.courant); // the same on all ranks
    if (!(step.dt / limit < most_fluid_steps)) return fail_at(limit, step.dt);
    if (bodies_) {
        bodies_->begin_interval(step.begin);
        to_ = step.end();
    }
    steps_ += flow_->step_within(step.begin, step.dt, plan_.courant);
}

void FluidInteraction::follow_rods() {
    const ImmersedRods& rods = *bodies_->rods();
    std::vector<double> along_x(rods.rods().local().size()); // sums over nodes, by rod: threads read rods side by side
    rods.read(lag_, [&](int, std::size_t i, const RodCopy& rod) {
        for (const Slot<1>& slot : rod.state) along_x[i] += lane(slot.position, 0).x;
    });
    double nodes = 0;
    for (const RodGroup& group : groups_) nodes += static_cast<double>(group.count() * group.slots());
    const double middle = exact_sums(comm_, std::span(&along_x, 1)).front() / nodes;
    if (!middle_at_start_) middle_at_start_ = middle;
    const auto cells = static_cast<std::int64_t>((middle - *middle_at_start_) / plan_.constants.grid.h);
    if (cells == moved_) return;
    flow_->move_box(static_cast<int>(cells - moved_));
    move_box_to(cells);
}

void FluidInteraction::move_box_to(std::int64_t cells) {
    moved_ = cells;
    bodies_->set_box_shift(box_shift());
}

FluidInteraction::RodsInBox FluidInteraction::rods_in_box() const {
    FluidGrid box = plan_.constants.grid;
    box.lower += box_shift();
    const double rounding = 1e-9 * box.h; // of ends that are held at a face
    const ImmersedRods& rods = *bodies_->rods();
    const std::span<const LocalRod> local = rods.rods().local();
    std::vector<RodsInBox> found(local.size()); // by rod: threads read rods side by side
    rods.read(lag_, [&](int, std::size_t i, const RodCopy& rod) {
        RodsInBox& mine = found[i];
        const BodyShape* body = nth(groups_, local[i].group).body();
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            const Vec3d v = lane(rod.state[k].velocity, 0);
            const double turning = body ? body->reach * norm(lane(rod.state[k].spin, 0)) : 0;
            mine.speed = std::max(mine.speed, std::abs(v.x) + std::abs(v.y) + std::abs(v.z) + turning);
            if (!plan_.two_way() || mine.outside != nobody) continue;
            if (const auto face = face_beyond(box, lane(rod.state[k].position, 0), rounding)) {
                mine.outside = local[i].gid;
                mine.rod = i;
                mine.node = k;
                mine.face = *face;
            }
        }
    });
    RodsInBox all;
    double speed = 0;
    for (const RodsInBox& one : found) {
        speed = std::max(speed, one.speed);
        if (one.outside < all.outside) all = one;
    }
    all.speed = speed;
    return all;
}

void FluidInteraction::stop_outside(const RodsInBox& mine, const Step& first) const {
    const std::int64_t gid = comm_.min(mine.outside);
    if (gid == nobody) return;
    throw NumericalError(
        comm_.first_text(mine.outside == gid ? text_outside(mine.rod, mine.node, mine.face, first) : std::string()));
}

std::string FluidInteraction::text_outside(std::size_t i, std::size_t node, const FluidFace& face,
                                           const Step& first) const {
    const LocalRod& rod = bodies_->rods()->rods().local()[i];
    const RodGroup& group = nth(groups_, rod.group);
    const FluidBoundary bound = nth(plan_.constants.grid.boundary, face.direction);
    const char along = "xyz"[face.direction];
    const bool could_follow = face.direction == 0 && !plan_.follows_rods && bound != FluidBoundary::through;
    const std::string name = group.body() ? fmt::format("body {} of '{}': its centre", rod.index, group.name())
                                          : fmt::format("rod {} of '{}': element {}", rod.index, group.name(),
                                                        std::min<std::size_t>(node, group.element.size() - 1));
    return fmt::format("{} has left the fluid through its {} face across {} (\"{}\", {} = {:g} m) by t = {:.6g} s: "
                       "nothing there carries the inertia and the drag that it has within the fluid\n"
                       "  what holds: more cells along {} (fluid.cells, fluid.lower, or margins){}, an end before it "
                       "gets there, time.duration = "
                       "{:.6g}, or immersion.coupling = \"one_way\"",
                       name, face.upper ? "upper" : "lower", along, nth(fluid_boundary_names, bound), along, face.at,
                       first.begin, along, could_follow ? ", fluid.follows_rods = true" : "",
                       first.begin - static_cast<double>(plan_.every) * first.dt);
}

double FluidInteraction::step_by_slip(double speed, double whole, double shortest) const {
    constexpr double growth = 1.25;  // of a step over the last one, or by one of the shortest
    constexpr double nothing = 1e-4; // of a cell, in a step of the plan: no motion that counts
    if (!(plan_.largest_slip > 0) || !(last_length_ > 0) || !(slip() * whole > nothing * plan_.constants.grid.h))
        return HUGE_VAL;
    return std::min(std::max(growth * last_length_, last_length_ + shortest),
                    last_length_ * plan_.largest_slip * speed / slip());
}

bool FluidInteraction::choose_part(const Step& first) {
    if (plan_.follows_rods) follow_rods();
    const RodsInBox rods = rods_in_box();
    if (plan_.two_way()) stop_outside(rods, first);
    const std::int64_t left = schedule_.units_left(first.before());
    const double shortest = static_cast<double>(schedule_.unit()) * first.dt,
                 whole = static_cast<double>(plan_.every) * first.dt, of_rods = comm_.max(rods.speed);
    const double by_rods = of_rods > 0 ? plan_.courant * plan_.constants.grid.h / of_rods : HUGE_VAL;
    speed_ = std::max(comm_.max(flow_->largest_speed()), of_rods);
    const double limit = std::min(flow_->step_limit(plan_.courant), by_rods);
    const auto steps_of = [&](double length) {
        return static_cast<std::int64_t>(std::min(1.0 * left, std::floor(length / shortest * (1 + 1e-12))));
    };
    if (!(limit >= shortest * (1 - 1e-12))) {
        fail_with_rods(limit, first.dt);
        return false;
    }
    if (limit < whole * (1 - 1e-12))
        speed_to_expect_ = std::max(speed_to_expect_, plan_.courant * plan_.constants.grid.h / limit);
    if (plan_.largest_slip > 0 && last_length_ > 0 && speed_ > 0)
        largest_share_ = std::max(largest_share_, slip() / speed_);
    const std::int64_t most =
        std::max<std::int64_t>(1, std::min(steps_of(limit), steps_of(step_by_slip(speed_, whole, shortest))));
    const std::int64_t steps = (left + most - 1) / most; // of about the same length until the next meeting of the plan
    schedule_.begin_part(first.before(), (left + steps - 1) / steps);
    if (schedule_.interval_begins(first.before())) {
        bodies_->begin_interval(first.begin);
        to_ = first.begin + whole;
    }
    return true;
}

std::array<const double*, 3> FluidInteraction::velocities() const {
    return {flow_->velocity(0).data(), flow_->velocity(1).data(), flow_->velocity(2).data()};
}

ForceBalance::Stage FluidInteraction::stage_of(int s, double dt) const {
    const double share = static_cast<double>(schedule_.steps_of_share()) * dt;
    const auto before = static_cast<double>(schedule_.shares_before(s)),
               until = static_cast<double>(schedule_.shares_before(s + 1));
    return {.begin = share * before,
            .length = share * (until - before),
            .step = static_cast<double>(schedule_.part()) * dt};
}

void FluidInteraction::begin_stage(int s, const Step& first) {
    ForceBalance* const balance = bodies_->balance();
    bodies_->set_lag(first.index == 1 ? 0 : lag_); // rods begin with positions in time
    bodies_->note_motions();
    if (!balance) return bodies_->set_lag(lag_); // rods do not wait for it
    ForceBalance::Stage stage = stage_of(s, first.dt);
    const double from = first.begin - stage.begin;
    stage.begin = first.begin;
    if (s == 0) bodies_->begin_step(first.begin, velocities());
    bodies_->expect_stage(stage);
    flow_->begin_stage(s, from, stage.step);
    bodies_->begin_stage(stage);
    bodies_->set_lag(lag_);
}

void FluidInteraction::end_stage(int s, const Step& step) {
    const ForceBalance::Stage stage = stage_of(s, step.dt);
    const double from = step.end() - stage.begin - stage.length;
    ForceBalance* const balance = bodies_->balance();
    bodies_->take_motions();
    if (balance) bodies_->find_marker_velocities(stage);
    else flow_->begin_stage(s, from, stage.step);
    flow_->end_stage(s, from, stage.step);
    const bool last = s + 1 == schedule_.stages();
    if (balance) bodies_->end_stage(plan_.constants.density);
    if (balance && last) balance->end_step(lag_);
    if (last) {
        ++steps_;
        last_length_ = stage.step;
    }
}

std::string FluidInteraction::invalid() const {
    if (!failure_.empty()) return failure_;
    return std::isfinite(flow_->largest_speed())
               ? std::string()
               : std::string("the velocity of the fluid is not finite: its step is too long for its driving") +
                     (groups_.empty() ? "; a smaller fluid.courant would do" : "");
}

void FluidInteraction::add_probes(std::vector<Figure>& all) const {
    if (plan_.probes.empty()) return;
    static constexpr std::array<std::string_view, 4> columns{"velocity_x[m/s]", "velocity_y[m/s]", "velocity_z[m/s]",
                                                             "pressure[Pa]"};
    for (const FluidProbeSpec& probe : plan_.probes) {
        std::array<std::vector<double>, 4> terms = probe_terms(*flow_, probe.at);
        for (std::size_t c = 0; c < columns.size(); ++c)
            all.push_back({fmt::format("{}_{}", probe.name, columns[c]), Figure::Of::sum, std::move(terms[c])});
    }
}

void FluidInteraction::add_loads(std::vector<Figure>& all) const {
    const auto add = [&](const std::string& name, const Vec3d& vector, const char* unit) {
        for (int c = 0; c < 3; ++c)
            all.push_back(
                {fmt::format("{}_{}[{}]", name, "xyz"[c], unit), Figure::Of::same, {component_of(vector, c)}});
    };
    const double density = plan_.constants.density;
    for (std::size_t o = 0; o < plan_.obstacles.size(); ++o) {
        add(plan_.obstacles[o].name + "_force", bodies_->force_on_obstacle(o, density, to_), "N");
        add(plan_.obstacles[o].name + "_couple", bodies_->couple_on_obstacle(o, density, to_), "N m");
    }
    for (std::size_t g = 0; g < groups_.size(); ++g)
        add(groups_[g].name() + "_fluid_force", bodies_->force_on_rods(g, density, to_), "N");
    if (const auto power = bodies_->power(density, to_)) {
        all.push_back({"fluid_power_given[W]", Figure::Of::same, {power->given}});
        all.push_back({"fluid_power_lost[W]", Figure::Of::same, {power->lost}});
    }
    for (const LoadColumns& columns : plan_.single_loads.columns) {
        const Immersion::MeanLoad load = bodies_->load_on_single(columns.single, density, to_);
        add(columns.name, columns.couple ? load.couple : load.force, columns.couple ? "N m" : "N");
    }
}

std::vector<Figure> FluidInteraction::figures(const Sample&) const {
    using Of = Figure::Of;
    const std::vector<FlowFigures> rows = flow_->figures();
    const auto terms = [&](auto&& of) {
        std::vector<double> all;
        for (const FlowFigures& row : rows) all.push_back(of(row));
        return all;
    };
    const auto largest = [&](double FlowFigures::*of) {
        double most = 0;
        for (const FlowFigures& row : rows) most = std::max(most, row.*of);
        return std::vector{most};
    };
    std::vector<Figure> all{
        {"fluid_energy[J]", Of::sum, terms([](const FlowFigures& f) { return f.kinetic_energy; })},
        {"fluid_dissipation[W]", Of::sum, terms([](const FlowFigures& f) { return f.dissipation; })},
        {"fluid_enstrophy[m^3/s^2]", Of::sum, terms([](const FlowFigures& f) { return f.enstrophy; })},
        {"fluid_momentum_x[kg m/s]", Of::sum, terms([](const FlowFigures& f) { return f.momentum.x; })},
        {"fluid_momentum_y[kg m/s]", Of::sum, terms([](const FlowFigures& f) { return f.momentum.y; })},
        {"fluid_momentum_z[kg m/s]", Of::sum, terms([](const FlowFigures& f) { return f.momentum.z; })},
        {"fluid_max_divergence[1/s]", Of::largest, largest(&FlowFigures::divergence)},
        {"fluid_max_speed[m/s]", Of::largest, largest(&FlowFigures::speed)},
        {"fluid_steps[-]", Of::same, {static_cast<double>(steps_)}}};
    add_probes(all);
    const auto only_of_steps = [&all] {
        for (Figure& figure : all) figure.of_steps = true;
        return std::move(all);
    };
    if (!bodies_) return only_of_steps();
    add_loads(all);
    if (const ForceBalance* const balance = bodies_->balance()) {
        const std::vector<Vec3d> of_slots = balance->momentum(lag_);
        for (int c = 0; c < 3; ++c) {
            std::vector<double> of_all;
            for (const FlowFigures& row : rows) of_all.push_back(component_of(row.momentum, c));
            for (const Vec3d& slot : of_slots) of_all.push_back(component_of(slot, c));
            all.push_back({fmt::format("coupled_momentum_{}[kg m/s]", "xyz"[c]), Of::sum, of_all});
        }
    }
    if (bodies_->has_markers()) all.push_back({"slip[m/s]", Of::same, {slip()}});
    return only_of_steps();
}

SavedNumbers FluidInteraction::saved() const {
    WholeState state(comm_, *flow_);
    std::vector<double> numbers{static_cast<double>(steps_), flow_->time(), bodies_ ? slip() : 0, last_length_};
    const auto keep = [&](const std::vector<double>& more) { numbers.insert(numbers.end(), more.begin(), more.end()); };
    keep(meshes_.saved());
    if (plan_.follows_rods) keep({static_cast<double>(moved_), middle_at_start_.value_or(0)});
    if (bodies_ && bodies_->balance()) keep(bodies_->balance()->saved(comm_));
    if (bodies_) keep(bodies_->saved_held());                  // empty where nothing is held
    const PressureInTime& pressure = pressure_in_time(*flow_); // last: programs before it did not know it
    numbers.push_back(pressure.pressure_time().value_or(no_time));
    numbers.push_back(pressure.pressure_gain().times);
    SavedNumbers kept{
        .name = saved_name(), .numbers = std::move(numbers), .columns = state.numbers_of_plane(), .rows = {}};
    // Frames of this step are written again by a run that goes on from it, so the gain of the pressure is kept where
    // they have it.
    const PlaneExchange exchange(comm_, plan_.constants.grid, flow_->pencils(), 0);
    std::vector<double> gain;
    if (writes_pressure(plan_)) {
        kept.columns += cells_of_plane(exchange.layout());
        gain.assign(pressure.pressure_gain().field.begin(), pressure.pressure_gain().field.end());
        if (flow_->pencils().across() > 1) {
            gain.resize(exchange.layout().size());
            exchange.to_planes(pressure.pressure_gain().field, gain);
        }
    }
    kept.rows.reserve(kept.columns * static_cast<std::size_t>(state.planes().count));
    const auto append = [&](std::span<const double> row) { kept.rows.insert(kept.rows.end(), row.begin(), row.end()); };
    for (int k = 0; k < state.planes().count; ++k) {
        state.for_rows(k, append);
        if (!gain.empty()) for_rows_of(exchange.layout(), gain, k, append);
    }
    return kept;
}

void FluidInteraction::restore(const SavedNumbers& kept) {
    constexpr std::size_t of_clock = 4; // steps, time, slip and length of the last step
    if (kept.numbers.size() < of_clock) throw IoError("the fluid of a checkpoint differs from the fluid of the scene");
    auto more = meshes_.after(std::span(kept.numbers).subspan(of_clock));
    WholeState state(comm_, *flow_);
    const PlaneExchange exchange(comm_, plan_.constants.grid, flow_->pencils(), 0);
    std::vector<double> gain;
    if (kept.columns == state.numbers_of_plane() + cells_of_plane(exchange.layout()))
        gain.resize(exchange.layout().size());
    if ((kept.columns != state.numbers_of_plane() && gain.empty()) ||
        kept.rows.size() != kept.columns * static_cast<std::size_t>(state.planes().count))
        throw IoError("the fluid of a checkpoint differs from the fluid of the scene");
    steps_ = steps_before_ = static_cast<std::int64_t>(kept.numbers.at(0));
    auto from = kept.rows.begin();
    const auto take = [&](std::span<double> row) {
        std::copy_n(from, row.size(), row.begin());
        from += static_cast<std::ptrdiff_t>(row.size());
    };
    for (int k = 0; k < state.planes().count; ++k) {
        state.for_rows(k, take);
        if (!gain.empty()) for_rows_of(exchange.layout(), std::span(gain), k, take);
    }
    state.put_back();
    flow_->refresh(kept.numbers.at(1));
    slip_before_ = kept.numbers.at(2);
    last_length_ = kept.numbers.at(3);
    if (plan_.follows_rods) {
        move_box_to(static_cast<std::int64_t>(more[0]));
        middle_at_start_ = steps_ > 0 ? std::optional(more[1]) : std::nullopt;
        more = more.subspan(2);
    }
    if (bodies_ && bodies_->balance()) {
        const std::size_t of_balance = bodies_->balance()->saved_numbers();
        if (more.size() < of_balance) throw IoError("the fluid of a checkpoint differs from the fluid of the scene");
        bodies_->balance()->restore(more.first(of_balance));
        more = more.subspan(of_balance);
    }
    PressureInTime& pressure = pressure_in_time(*flow_);
    pressure.set_pressure_time(std::nullopt);
    if (more.size() % HeldVectors::record == 2) {
        const double time = more[more.size() - 2], times = more.back();
        if (time != no_time) pressure.set_pressure_time(time);
        if (!gain.empty() && writes_pressure(plan_)) {
            const std::span<double> field = pressure.restore_pressure_gain(times);
            if (flow_->pencils().across() > 1) exchange.to_rows(gain, field);
            else std::copy(gain.begin(), gain.end(), field.begin());
        }
        more = more.first(more.size() - 2);
    }
    if (bodies_) bodies_->restore_held(more);
    failure_.clear();
    needed_.clear();
    begun_ = -1;
}

std::uint64_t
FluidInteraction::digest() const { // that of the rows of saved(), without a copy of them, and of forces by marker
    WholeState state(comm_, *flow_);
    std::vector<std::uint64_t> hash(static_cast<std::size_t>(state.planes().count));
    threads_.for_each(hash.size(), [&](std::size_t k, int) {
        std::uint64_t h = hash_begin(state.planes().first + static_cast<std::int64_t>(k));
        state.for_rows(static_cast<int>(k), [&](std::span<double> row) {
            for (const double x : row) h = hash_with(h, x);
        });
        hash[k] = hash_end(h);
    });
    if (bodies_)
        bodies_->for_held([&](const HeldVectors& held) {
            for (std::size_t m = 0; m < held.values().size(); ++m) {
                const Vec3d& f = held.values()[m];
                const double numbers[] = {f.x, f.y, f.z};
                hash.push_back(hash_numbers(held.identities()[m], numbers));
            }
        });
    if (bodies_ && bodies_->balance()) hash.push_back(bodies_->balance()->digest());
    if (moved_ != 0 && comm_.root()) hash.push_back(hash_end(hash_with(hash_begin(moved_), 0)));
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
