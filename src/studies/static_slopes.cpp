#include "studies/static_slopes.hpp"

#include "contact/static_friction.hpp"
#include "core/stop.hpp"
#include "diagnostics/observables.hpp"
#include "physics/audit/audit_plan.hpp"
#include "physics/contact/contact_interaction.hpp"
#include "physics/walls/wall_interaction.hpp"
#include "skein/core/error.hpp"
#include "studies/equilibrium_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {

void refuse_singular() {
    throw NumericalError("the stiffness at the equilibrium is singular, as at a limit or branch point or where "
                         "several bodies move without a change of force: slopes have no value there");
}

Equilibrium find_or_stop(StaticSystem& system, StaticState& state, double time) {
    NewtonOptions options;
    options.friction = true;
    options.watch = [](const NewtonProgress&) { return !stop_requested(); };
    Equilibrium found = NewtonSolver(system, options).find(state, time);
    stop_where_asked("an equilibrium was looked for");
    return found;
}

BegunBodies begun_bodies(const World& world) {
    std::vector<std::size_t> all(world.rods().local().size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    const ContactInteraction* contacts = contacts_of(world.interactions());
    return {share_bodies(world, all, false), contacts ? contacts->memory() : std::vector<SavedContact>()};
}

namespace {

/// The state and the memory of a checkpoint. Throws InputError where its bodies have other elements.
StaticState begin_with(const BegunBodies& begun, StaticCase& one, StaticState state) {
    const SharedBodies& bodies = begun.bodies;
    if (bodies.slot.size() != state.slot.size())
        throw InputError("start.from: the checkpoint has bodies with other numbers of elements");
    StaticRods& at_rest = one.system->at_rest();
    state.slot = bodies.slot;
    one.system->map().gather(state.slot);
    one.system->refresh(state);
    for (std::size_t i = 0; i < bodies.rods.size(); ++i)
        if (!bodies.wall_memory[i].empty()) at_rest.set_wall_memory(i, bodies.wall_memory[i]);
    if (one.system->contacts()) one.system->contacts()->set_springs(begun.contacts);
    state.joint_memory = joint_memory_of(at_rest, bodies.memory);
    return state;
}

} // namespace

void require_held_as_placed(StaticCase& one, const BegunBodies& begun) {
    constexpr double alike = 1e-9; // over the length, or turn
    StaticSystem& system = *one.system;
    const StaticState scene = start_of(system, one.groups, one.rods);
    StaticState there = begin_with(begun, one, scene), here = there;
    system.hold_at(there);
    system.lead_ends(there);
    system.hold_at(scene);
    system.lead_ends(here);
    for (std::size_t s = 0; s < here.slot.size(); ++s) {
        const Slot<1>&a = here.slot[s], &b = there.slot[s];
        const double way = norm(lane(a.position, 0) - lane(b.position, 0)),
                     turn = norm(relative_rotation(lane(a.director, 0), lane(b.director, 0)));
        if (way > alike * system.length() || turn > alike)
            throw InputError("start.from: the checkpoint holds an end elsewhere than the scene places it, as one that "
                             "was caught, so that slopes by numbers of the scene are not known: write its place into "
                             "the scene, or leave start.from out");
    }
}

StaticState equilibrium_of(StaticCase& one, double time, const BegunBodies* begun) {
    StaticState state = start_of(*one.system, one.groups, one.rods);
    if (begun) state = begin_with(*begun, one, std::move(state));
    const Equilibrium found = find_or_stop(*one.system, state, time);
    if (!found.found) throw NumericalError(fmt::format("no equilibrium was found: {}", found.reason));
    one.system->refresh(state);
    return state;
}

void ObservedCase::make() {
    world_ = std::make_unique<World>(*comm_, *threads_, at_->groups, at_->plan, Protocol::asynchronous, Balance::never);
    observation_.emplace(*world_, at_->scene);
    if (at_->plan.has<AuditPlan>()) observation_->begin_audit(*world_, std::nullopt);
    names_ = observation_->names();
}

const std::vector<std::string>& ObservedCase::names() {
    if (!world_) make();
    return names_;
}

std::span<const Slot<1>> ObservedCase::slots_of(std::size_t i, std::span<const Slot<1>> all) const {
    const auto rod = static_cast<std::size_t>(world_->rods().local()[i].gid);
    const std::size_t first = at_->system->first_slot(rod);
    return all.subspan(first, at_->system->first_slot(rod + 1) - first);
}

std::vector<double> ObservedCase::values(const StaticState& state) {
    if (!world_) make();
    Rods& rods = world_->rods();
    WallInteraction* walls = walls_of(world_->interactions());
    std::vector<Slot<1>> own;
    at_->system->at_rest().set_joint_memory(state.joint_memory);
    for (std::size_t i = 0; i < rods.local().size(); ++i) {
        const auto rod = static_cast<std::size_t>(rods.local()[i].gid);
        const std::span<const Slot<1>> slots = slots_of(i, state.slot);
        own.assign(slots.begin(), slots.end());
        for (Slot<1>& slot : own) { // the start of a scene may have some
            set_lane(slot.velocity, 0, Vec3d{0, 0, 0});
            set_lane(slot.spin, 0, Vec3d{0, 0, 0});
        }
        rods.import_rod(i, own);
        if (!friction_.empty() && !friction_.walls[rod].empty()) walls->set_memory(i, friction_.walls[rod]);
        put_joints(at_->system->at_rest(), rod, rods, i);
    }
    if (ContactInteraction* contacts = contacts_of(world_->interactions())) contacts->set_memory(friction_.contacts);
    world_->show_solution(time_, [&](std::size_t i, std::span<Slot<1>> slots) {
        if (!friction_.empty()) set_rates_from(slots_of(i, friction_.reference), slots);
    });
    std::vector<double> values = observation_->values();
    values[observed_turn_per_cell + 1] = 0; // the defect of directors, which is rounding
    return values;
}

Unknown RestQuantity::at(ObservedCase& observed, const StaticState& state) const {
    const Unknown first = places ? places(observed.at(), state) : Unknown(0);
    if (observables.empty()) return first;
    Unknown all = of_observables(observed.values(state), first.size() + static_cast<Eigen::Index>(observables.size()));
    all.head(first.size()) = first;
    return all;
}

Unknown RestQuantity::of_observables(const std::vector<double>& change, Eigen::Index size) const {
    Unknown all = Unknown::Zero(size);
    Eigen::Index row = size - static_cast<Eigen::Index>(observables.size());
    for (const std::size_t one : observables) all[row++] = change[one];
    return all;
}

bool slips_along(const Unknown& change, const StaticSolution& solution, StaticSystem& system,
                 const StaticState& state) {
    constexpr double way = 1e-7, rounding = 1e-9, share = 1e-2; // over the length, or turn; of forces; of the change
    const double size = system.size(change);
    if (!(size > 0) || !std::isfinite(size)) return false;
    StaticSystem::Balance here = system.balance(state, false);
    const Unknown residual = here.residual;
    const Unknowns::Moves moves =
        system.map().moves({change.data(), static_cast<std::size_t>(change.size())}, state.slot);
    const auto moved = [&](double by) {
        StaticState own = state;
        system.map().apply(moves, by / size, own.slot);
        system.refresh(own);
        return system.balance(own, false).residual;
    };
    const Unknown more = moved(way), less = moved(-way), half = moved(0.5 * way) + moved(-0.5 * way);
    // Second differences of smooth loads go with the square of the way, and drop out.
    const Unknown kink = 4 * (half - 2 * residual) - (more - 2 * residual + less);
    here.residual = kink;
    return system.relative(here) > rounding && system.size(solution.solve(kink)) > share * way;
}

void refuse_slip(const std::string& key) {
    throw NumericalError(
        fmt::format("slopes by '{}' have no value: friction acts otherwise if the number goes to one "
                    "side than if it goes to the other, as of a contact that slips at its limit, or of "
                    "a Hertzian one that is pressed less",
                    key));
}

Unknown slope_along(const Unknown& change, const RestQuantity& quantity, ObservedCase& observed,
                    const StaticState& state) {
    constexpr double way = 1e-6; // over the length, or turn: central differences are exact to its square
    const StaticSystem& system = *observed.at().system;
    const double size = system.size(change), step = size > 0 ? way / size : 1;
    const Unknowns::Moves moves =
        system.map().moves({change.data(), static_cast<std::size_t>(change.size())}, state.slot);
    const auto moved = [&](double by) {
        StaticState own = state;
        system.map().apply(moves, by, own.slot);
        return quantity.at(observed, own);
    };
    return (moved(step) - moved(-step)) / (2 * step);
}

} // namespace skein
