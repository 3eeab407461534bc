#include "studies/equilibrium_study.hpp"

#include "core/timer.hpp"
#include "mechanics/rod_copies.hpp"
#include "physics/contact/contact_interaction.hpp"
#include "physics/walls/wall_interaction.hpp"
#include "simulation/branch.hpp"
#include "skein/core/error.hpp"
#include "studies/scene_family.hpp"
#include "tiles/clusters.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace skein {

namespace {

/// Rods that are solved together, in the order of the rank's rods.
std::vector<std::vector<std::size_t>> pieces_of(std::span<const RodGroup> groups, std::span<const LocalRod> rods,
                                                bool touch) {
    std::map<std::pair<const void*, std::int64_t>, std::size_t> of_copy;
    std::vector<std::vector<std::size_t>> pieces;
    if (touch && !rods.empty()) {
        pieces.emplace_back(rods.size());
        std::iota(pieces.front().begin(), pieces.front().end(), std::size_t{0});
        return pieces;
    }
    for (std::size_t i = 0; i < rods.size(); ++i) {
        const RodGroup& group = nth(groups, rods[i].group);
        if (!group.assembly()) {
            pieces.push_back({i});
            continue;
        }
        const auto [at, fresh] = of_copy.try_emplace({group.assembly(), group.copy_of(rods[i].index)}, pieces.size());
        if (fresh) pieces.emplace_back();
        pieces[at->second].push_back(i);
    }
    return pieces;
}

/// Stability of all pieces, and how many are not known.
std::string stability_text(const EquilibriumReport& r) {
    if (r.unknown_stability == r.pieces) return "not known, as the loads have no potential";
    std::string text = r.unstable == 0 ? "stable" : fmt::format("unstable, {} of {} pieces", r.unstable, r.pieces);
    if (r.asymmetry > 0)
        text += fmt::format(", by the symmetric part of the stiffness; friction adds {:.1g} of it", r.asymmetry);
    if (r.unknown_stability > 0)
        text += fmt::format("; of {} pieces not known, as the loads have no potential", r.unknown_stability);
    return text;
}

} // namespace

StaticScene::StaticScene(World& world) : world_(world) {
    const Rods& rods = world.rods();
    std::shared_ptr<Walls> walls;
    if (world.walls()) walls = std::make_shared<Walls>(*world.walls());
    const ContactInteraction* contacts = contacts_of(world.interactions());
    const WallInteraction* at_walls = walls_of(world.interactions());
    const bool touch = world.plan.find<ContactPlan>() != nullptr;
    for (std::vector<std::size_t>& members : pieces_of(world.groups, rods.local(), touch)) {
        std::vector<LocalRod> own;
        for (const std::size_t i : members) own.push_back(rods.local()[i]);
        StaticPiece& piece = pieces_.emplace_back();
        piece.system = make_static_system(world.plan, world.groups, own, walls, world.threads);
        for (const std::size_t i : members) {
            const LocalRod& local = rods.local()[i];
            const RodGroup& group = nth(world.groups, local.group);
            std::vector<Slot<1>> state(to_index(group.slots()));
            rods.export_rod(i, state);
            with_rod(group, local.index, [&](const RodGroup& one) { synchronise(one, state, world.clock.lag()); });
            piece.state.slot.insert(piece.state.slot.end(), state.begin(), state.end());
            if (at_walls) piece.system->at_rest().set_wall_memory(piece.rods.size(), at_walls->memory(i));
            piece.rods.push_back(i);
        }
        if (contacts) piece.system->contacts()->set_springs(contacts->memory());
        piece.system->map().gather(piece.state.slot);
        piece.system->refresh(piece.state);
    }
}

void StaticScene::put_back() const {
    Rods& rods = world_.rods();
    ContactInteraction* contacts = contacts_of(world_.interactions());
    WallInteraction* walls = walls_of(world_.interactions());
    for (const StaticPiece& piece : pieces_) {
        if (contacts && piece.system->contacts()->rubs()) contacts->set_memory(piece.system->contacts()->springs());
        for (std::size_t i = 0; i < piece.rods.size(); ++i) {
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
        }
    }
}

EquilibriumReport find_equilibrium(StaticScene& scene, double time, const NewtonOptions& options) {
    const double began = wall_seconds();
    const Communicator& comm = scene.world().comm;
    std::vector<Equilibrium> found(scene.pieces().size());
    const std::function<void(std::size_t, int)> solve = [&](std::size_t i, int) {
        StaticPiece& piece = scene.pieces()[i];
        NewtonSolver solver(*piece.system, options);
        found[i] = solver.find(piece.state, time);
    };
    scene.world().threads.for_each(found.size(), solve);

    EquilibriumReport report;
    std::int64_t unknowns = 0, unstable = 0, no_signs = 0, neutral = 0, most = 0, steps = 0;
    std::string reason, names, factor;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const Equilibrium& one = found[i];
        const auto all =
            static_cast<std::int64_t>(std::accumulate(one.iterations.begin(), one.iterations.end(), std::size_t{0}));
        if (all >= most) report.last = one.last.passes;
        most = std::max(most, all);
        steps = std::max(steps, static_cast<std::int64_t>(one.iterations.size()));
        unknowns += scene.pieces()[i].system->unknowns();
        unstable += one.negative > 0;
        no_signs += one.negative < 0;
        neutral += one.neutral;
        report.residual = std::max(report.residual, one.residual);
        report.asymmetry = std::max(report.asymmetry, one.asymmetry);
        report.share = std::min(report.share, one.share);
        if (reason.empty() && !one.found)
            reason = fmt::format("{}: {}", scene.pieces()[i].system->rod_name(0), without_repetition(one.reason));
        if (names.empty() && one.neutral > 0) names = fmt::format("{}", fmt::join(one.neutral_names, "; "));
        if (factor.empty()) factor = one.factor;
    }
    report.pieces = comm.sum(static_cast<std::int64_t>(found.size()));
    report.unknowns = comm.sum(unknowns);
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
        "Newton: {} unknowns in {} pieces{}{}; at most {} load steps and {} iterations of a piece, {:.3g} s\n",
        r.unknowns, r.pieces, r.factor.empty() ? "" : ", ", r.factor, r.load_steps, r.iterations, r.seconds);
    for (const NewtonPass& pass : r.last)
        text += fmt::format("  residual {:.2e}, correction {:.2e}\n", pass.residual, pass.correction);
    if (!r.found) return text;
    text += fmt::format("Balance: residual {:.2g} of the acting forces\n", r.residual);
    text += "Stability: " + stability_text(r) + "\n";
    if (r.neutral > 0) text += fmt::format("Neutral: {} motions that change no load: {}\n", r.neutral, r.neutral_names);
    return text;
}

} // namespace skein
