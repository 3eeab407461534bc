#include "studies/equilibrium_study.hpp"

#include "contact/static_friction.hpp"
#include "core/stop.hpp"
#include "core/timer.hpp"
#include "equilibrium/large_factor.hpp"
#include "physics/contact/contact_interaction.hpp"
#include "physics/walls/wall_interaction.hpp"
#include "simulation/branch.hpp"
#include "skein/core/error.hpp"
#include "studies/scene_family.hpp"
#include "tiles/clusters.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace skein {

namespace {

/// Bodies of this rank that are solved for together, places in local(), by the least number of one of them.
using Members = std::map<std::int64_t, std::vector<std::size_t>>;

Members members_of(std::span<const RodGroup> groups, std::span<const LocalRod> rods) {
    std::map<std::pair<const void*, std::int64_t>, std::vector<std::size_t>> copies;
    Members members;
    for (std::size_t i = 0; i < rods.size(); ++i) {
        const RodGroup& group = nth(groups, rods[i].group);
        if (group.assembly()) copies[{group.assembly(), group.copy_of(rods[i].index)}].push_back(i);
        else members[rods[i].gid].push_back(i);
    }
    for (auto& [copy, own] : copies) {
        const auto first = std::min_element(own.begin(), own.end(),
                                            [&](std::size_t a, std::size_t b) { return rods[a].gid < rods[b].gid; });
        members.emplace(rods[*first].gid, own);
    }
    return members;
}

/// Takes out what all ranks solve for together: everything where bodies may touch, or large copies of assemblies.
Members take_shared(Members& members, const World& world, bool touch) {
    Members shared;
    if (touch) {
        for (const auto& [first, own] : members) shared[0].insert(shared[0].end(), own.begin(), own.end());
        members.clear();
        return shared;
    }
    if (world.comm.size() == 1) return shared;
    for (auto at = members.begin(); at != members.end();) {
        std::size_t slots = 0;
        for (const std::size_t i : at->second)
            slots += to_index(nth(world.groups, world.rods().local()[i].group).slots());
        const bool large = at->second.size() > 1 && slots * slot_unknowns >= to_index(large_unknowns);
        if (large) shared.insert(*at);
        at = large ? members.erase(at) : std::next(at);
    }
    return shared;
}

/// Keys on any rank, rising. Collective.
std::vector<std::int64_t> keys_of_all(const Communicator& comm, const Members& members) {
    std::vector<double> own;
    for (const auto& [first, bodies] : members) own.push_back(static_cast<double>(first));
    std::vector<std::int64_t> keys;
    for (const double key : comm.all_gather(own)) keys.push_back(static_cast<std::int64_t>(key));
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    return keys;
}

std::string names_of_neutral(const Equilibrium& one) {
    std::vector<std::string> names = one.neutral_names;
    if (one.loose > 0) names.push_back(fmt::format("{} of several bodies together", one.loose));
    return fmt::format("{}", fmt::join(names, "; "));
}

/// Stability of all pieces, and how many are not known.
std::string stability_text(const EquilibriumReport& r) {
    if (r.unknown_stability == r.pieces) return "not known, as the loads or bearings have no potential";
    std::string text = r.unstable == 0 ? "stable" : fmt::format("unstable, {} of {} pieces", r.unstable, r.pieces);
    if (r.asymmetry > 0)
        text += fmt::format(", by the symmetric part of the stiffness; friction adds {:.1g} of it", r.asymmetry);
    if (r.unknown_stability > 0)
        text +=
            fmt::format("; of {} pieces not known, as the loads or bearings have no potential", r.unknown_stability);
    return text;
}

} // namespace

StaticScene::StaticScene(World& world) : world_(world) {
    if (world.walls()) walls_ = std::make_shared<Walls>(*world.walls());
    const bool touch = world.plan.find<ContactPlan>() != nullptr;
    Members members = members_of(world.groups, world.rods().local());
    Members shared = take_shared(members, world, touch);
    const std::vector<std::int64_t> keys = keys_of_all(world.comm, shared);
    if (!keys.empty()) groups_ = groups_of_all(world);
    for (const std::int64_t key : keys) add(shared[key], groups_, true);
    for (const auto& [first, own] : members) add(own, world.groups, false);
    if (const ContactInteraction* contacts = contacts_of(world.interactions()))
        pieces_.front().system->contacts()->set_springs(contact_memory_of_all(world.comm, contacts->memory()));
}

void StaticScene::add(std::span<const std::size_t> own, std::span<const RodGroup> groups, bool shared) {
    SharedBodies bodies = share_bodies(world_, own, shared);
    StaticPiece& piece = pieces_.emplace_back();
    piece.shared = shared;
    piece.system =
        make_static_system(world_.plan, groups, bodies.rods, walls_, world_.threads, shared ? &world_.comm : nullptr);
    for (std::size_t i = 0; i < bodies.rods.size(); ++i)
        if (!bodies.wall_memory[i].empty()) piece.system->at_rest().set_wall_memory(i, bodies.wall_memory[i]);
    piece.state.joint_memory = joint_memory_of(piece.system->at_rest(), bodies.memory);
    piece.rods = std::move(bodies.local);
    piece.state.slot = std::move(bodies.slot);
    piece.system->map().gather(piece.state.slot);
    piece.system->refresh(piece.state);
}

void StaticScene::put_back() const {
    Rods& rods = world_.rods();
    ContactInteraction* contacts = contacts_of(world_.interactions());
    WallInteraction* walls = walls_of(world_.interactions());
    for (const StaticPiece& piece : pieces_) {
        piece.system->at_rest().set_joint_memory(piece.state.joint_memory);
        if (contacts && piece.system->contacts()->rubs()) contacts->set_memory(piece.system->contacts()->springs());
        for (std::size_t i = 0; i < piece.rods.size(); ++i) {
            if (piece.rods[i] == SharedBodies::elsewhere) continue;
            const auto begin = piece.state.slot.begin();
            std::vector<Slot<1>> state(begin + static_cast<std::ptrdiff_t>(piece.system->first_slot(i)),
                                       begin + static_cast<std::ptrdiff_t>(piece.system->first_slot(i + 1)));
            for (Slot<1>& slot : state) {
                set_lane(slot.velocity, 0, Vec3d{0, 0, 0});
                set_lane(slot.spin, 0, Vec3d{0, 0, 0});
            }
            rods.import_rod(piece.rods[i], state);
            if (const auto memory = piece.system->at_rest().wall_memory(i); !memory.empty())
                walls->set_memory(piece.rods[i], memory);
            put_joints(piece.system->at_rest(), i, rods, piece.rods[i]);
        }
    }
}

void StaticScene::show(double time, const StaticScene* from) const {
    put_back();
    if (!from) return world_.show_solution(time);
    std::vector<std::span<const Slot<1>>> then(world_.rods().local().size());
    for (const StaticPiece& piece : from->pieces_)
        for (std::size_t i = 0; i < piece.rods.size(); ++i) {
            const std::size_t first = piece.system->first_slot(i), last = piece.system->first_slot(i + 1);
            if (piece.rods[i] != SharedBodies::elsewhere)
                then[piece.rods[i]] = std::span(piece.state.slot).subspan(first, last - first);
        }
    world_.show_solution(time, [&](std::size_t i, std::span<Slot<1>> state) { set_rates_from(then[i], state); });
}

void StaticScene::take_springs(const StaticScene& other) {
    for (std::size_t i = 0; i < pieces_.size(); ++i)
        pieces_[i].system->set_friction_memory(other.pieces_[i].system->friction_memory(other.pieces_[i].state));
}

std::vector<double> joint_memory_of(StaticRods& at_rest, std::span<const std::vector<double>> kept) {
    at_rest.set_joint_memory({});
    for (std::size_t i = 0; i < kept.size(); ++i) at_rest.set_joint_memory_of(i, kept[i]);
    return {at_rest.joint_memory().begin(), at_rest.joint_memory().end()};
}

void put_joints(StaticRods& at_rest, std::size_t i, Rods& rods, std::size_t place) {
    const std::vector<double> own = at_rest.joint_memory_of(i);
    if (own.empty()) return;
    std::vector<double> all = rods.memory(place);
    std::copy(own.begin(), own.end(), all.end() - static_cast<std::ptrdiff_t>(own.size()));
    rods.set_memory(place, all);
}

void for_each_piece(StaticScene& scene, const std::function<void(std::size_t)>& act) {
    std::vector<StaticPiece>& pieces = scene.pieces();
    const auto shared = static_cast<std::size_t>(
        std::count_if(pieces.begin(), pieces.end(), [](const StaticPiece& piece) { return piece.shared; }));
    for (std::size_t i = 0; i < shared; ++i) act(i); // in the same order on all ranks, by the thread that has MPI
    scene.world().threads.for_each(pieces.size() - shared, [&](std::size_t i, int) { act(shared + i); });
}

namespace {

/// Equilibria of all pieces of this rank, or with `once` a correction of each. Throws Stopped where a signal ends one
/// on any rank. Collective.
std::vector<Equilibrium> equilibria_of(StaticScene& scene, double time, NewtonOptions options, SolutionWatch& watch,
                                       bool once = false) {
    const Communicator& comm = scene.world().comm;
    std::vector<Equilibrium> found(scene.pieces().size());
    for_each_piece(scene, [&](std::size_t i) {
        StaticPiece& piece = scene.pieces()[i];
        NewtonOptions own = options;
        own.watch = [&](const NewtonProgress& now) {
            const std::int64_t stop = stop_requested();
            watch.see(now);
            return !once && (piece.shared ? comm.max(stop) : stop) == 0;
        };
        found[i] = NewtonSolver(*piece.system, own).find(piece.state, time);
    });
    const std::int64_t stop = stop_requested();
    if (comm.max(stop) > 0)
        throw Stopped("stopped by a signal while the equilibrium was looked for; nothing was written");
    return found;
}

/// Pieces and unknowns of all ranks. Collective.
std::pair<std::int64_t, std::int64_t> size_of(const StaticScene& scene) {
    std::int64_t pieces = 0, unknowns = 0;
    for (const StaticPiece& piece : scene.pieces()) {
        if (!scene.counts(piece)) continue;
        ++pieces;
        unknowns += piece.system->unknowns();
    }
    return {scene.world().comm.sum(pieces), scene.world().comm.sum(unknowns)};
}

/// Bodies that touch or rub and still move at the start may be far from rest: names the fastest. Empty where none moves
/// by a thousandth of its radius while the slowest rod swings.
std::string text_of_motion(const StaticPiece& piece) {
    const StaticSystem& system = *piece.system;
    const double swing = 1 / std::sqrt(system.slow_eigenvalue());
    double fastest = 0;
    std::size_t of = 0;
    const bool meets = system.touches() || system.rubs();
    for (std::size_t rod = 0; meets && rod < system.rods().size(); ++rod)
        for (std::size_t s = system.first_slot(rod); s < system.first_slot(rod + 1); ++s) {
            const double speed = norm(lane(piece.state.slot[s].velocity, 0));
            if (speed <= fastest || speed * swing < 1e-3 * system.group(rod).element.front().radius) continue;
            fastest = speed;
            of = rod;
        }
    if (fastest == 0) return {};
    return fmt::format(
        "; at the start {} moves at {:.2g} m/s: a longer or more damped run brings bodies nearer to rest",
        system.rod_name(of), fastest);
}

} // namespace

SolutionPlan plan_equilibrium(StaticScene& scene, double time, const NewtonOptions& options) {
    const Communicator& comm = scene.world().comm;
    const auto [pieces, unknowns] = size_of(scene);
    SolutionWatch watch(false, pieces, unknowns);
    equilibria_of(scene, time, options, watch, true);
    SolutionPlan plan = watch.plan();
    const bool largest = plan.factor_bytes == comm.max(plan.factor_bytes);
    plan.factor = comm.first_text(largest ? plan.factor : std::string());
    plan.seconds = comm.max(largest ? plan.seconds : 0.0);
    plan.factor_bytes = comm.max(plan.factor_bytes);
    return plan;
}

EquilibriumReport find_equilibrium(StaticScene& scene, double time, const NewtonOptions& options, bool shown) {
    const double began = wall_seconds();
    const Communicator& comm = scene.world().comm;
    const auto [pieces, unknowns] = size_of(scene);
    std::vector<Equilibrium> found;
    {
        SolutionWatch watch(shown && comm.root(), pieces, unknowns);
        found = equilibria_of(scene, time, options, watch);
    }

    EquilibriumReport report;
    std::int64_t unstable = 0, no_signs = 0, neutral = 0, most = 0, steps = 0;
    std::string reason, names, factor;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (!scene.counts(scene.pieces()[i])) continue;
        const Equilibrium& one = found[i];
        const auto all =
            static_cast<std::int64_t>(std::accumulate(one.iterations.begin(), one.iterations.end(), std::size_t{0}));
        if (all >= most) report.last = one.last.passes;
        most = std::max(most, all);
        steps = std::max(steps, static_cast<std::int64_t>(one.iterations.size()));
        unstable += one.negative > 0;
        no_signs += one.negative < 0;
        neutral += one.neutral + one.loose;
        report.residual = std::max(report.residual, one.residual);
        report.asymmetry = std::max(report.asymmetry, one.asymmetry);
        report.share = std::min(report.share, one.share);
        if (reason.empty() && !one.found)
            reason = fmt::format("{}: {}{}", scene.pieces()[i].system->rod_name(0), without_repetition(one.reason),
                                 text_of_motion(scene.pieces()[i]));
        if (names.empty() && one.neutral + one.loose > 0) names = names_of_neutral(one);
        if (factor.empty()) factor = one.factor;
        report.factor_bytes = std::max(report.factor_bytes, factor_bytes(one.factor, one.factor_entries));
    }
    report.pieces = pieces;
    report.unknowns = unknowns;
    report.factor_bytes = comm.max(report.factor_bytes);
    report.unstable = comm.sum(unstable);
    report.unknown_stability = comm.sum(no_signs);
    report.neutral = comm.sum(neutral);
    report.load_steps = comm.max(steps);
    report.iterations = comm.max(most);
    report.residual = comm.max(report.residual);
    report.asymmetry = comm.max(report.asymmetry);
    report.share = -comm.max(-report.share);
    report.reason = comm.first_text(reason);
    report.neutral_names = comm.first_text(names);
    report.factor = comm.first_text(factor);
    report.found = report.reason.empty();
    report.seconds = wall_seconds() - began;
    return report;
}

std::string without_repetition(const std::string& reasons) {
    std::vector<std::string> all;
    for (std::size_t from = 0; from <= reasons.size();) {
        const std::size_t to = std::min(reasons.find("; ", from), reasons.size());
        std::string one = reasons.substr(from, to - from);
        if (std::find(all.begin(), all.end(), one) == all.end()) all.push_back(std::move(one));
        from = to + 2;
    }
    return fmt::format("{}", fmt::join(all, "; "));
}

void require_stable(const EquilibriumReport& r) {
    if (r.unstable > 0 || r.unknown_stability > 0)
        throw Error(Exit::unstable, "the stability of the equilibrium: " + stability_text(r));
}

std::string to_text(const EquilibriumReport& r) {
    std::string text = fmt::format(
        "Newton: {} unknowns in {} pieces{}; at most {} load steps and {} iterations of a piece, {:.3g} s\n",
        r.unknowns, r.pieces, r.factor.empty() ? "" : fmt::format(", {} of {:.2g} MB", r.factor, 1e-6 * r.factor_bytes),
        r.load_steps, r.iterations, r.seconds);
    for (const NewtonPass& pass : r.last)
        text += fmt::format("  residual {:.2e}, correction {:.2e}\n", pass.residual, pass.correction);
    if (!r.found) return text;
    text += fmt::format("Balance: residual {:.2g} of the acting forces\n", r.residual);
    text += "Stability: " + stability_text(r) + "\n";
    if (r.neutral > 0) text += fmt::format("Neutral: {} motions that change no load: {}\n", r.neutral, r.neutral_names);
    return text;
}

} // namespace skein
