#include "plan/plan.hpp"

#include "core/share_text.hpp"
#include "io/trajectory.hpp"
#include "io/vtk_series.hpp"
#include "neighbourhood/exposure.hpp"
#include "plan/doubts.hpp"
#include "plan/group_plan.hpp"
#include "plan/plan_steps.hpp"
#include "plan/stepping_cost.hpp"
#include "rod/body_shape.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/tile.hpp"
#include "tiles/rods.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

std::vector<TilingGroup> tiling_groups(const Plan& plan, std::span<const std::int64_t> counts) {
    std::vector<TilingGroup> groups;
    for (std::size_t g = 0; g < plan.groups.size(); ++g)
        groups.push_back({counts[g], plan.groups[g].elements, plan.groups[g].family,
                          plan.groups[g].own_sizes == OwnSizes::cut || plan.groups[g].own_sizes == OwnSizes::whole,
                          plan.groups[g].own_sizes == OwnSizes::whole});
    return groups;
}

/// Tiles across of so many rods of a group.
std::int64_t tiles_across(const GroupPlan& group, std::int64_t rods, int lanes) {
    if (group.own_sizes == OwnSizes::apart) return rods;
    const std::int64_t of_copy = group.rods_of_lane;
    return of_copy * Tiling::tiles((rods + of_copy - 1) / of_copy, lanes);
}

/// True where most elements are of rods that have a tile each, which lanes repeat.
bool most_are_apart(const Plan& plan) {
    std::int64_t apart = 0;
    for (const GroupPlan& p : plan.groups)
        if (p.own_sizes == OwnSizes::apart) apart += p.rods * p.elements;
    return 2 * apart > plan.elements;
}

/// Chooses lanes where rods alone use them, or where most of them leave lanes empty: what acts between rods has kernels
/// of that width too.
void choose_lanes(Plan& plan, std::span<const RodGroup> groups) {
    const auto side_by_side = [](const RodGroup& group) { return group.assembly() && !group.assembly()->lane_each; };
    Machine& m = plan.machine;
    const bool coupled = plan.coupling() != PhysicsPlan::Coupling::none || plan.acts_between_rods();
    if (m.most_lanes == 0 || (coupled && !most_are_apart(plan)) || groups.empty() ||
        std::any_of(groups.begin(), groups.end(), side_by_side))
        return;
    std::vector<TilingGroup> tiled = tiling_groups(plan, largest_share(plan));
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const std::int64_t of_copy =
            plan.groups[g].own_sizes == OwnSizes::apart ? tiled[g].rods : plan.groups[g].rods_of_lane;
        if (of_copy == 0) continue;
        tiled[g].rods = (tiled[g].rods + of_copy - 1) / of_copy;
        tiled[g].elements *= static_cast<int>(of_copy);
    }
    m.lanes = fastest_lanes(tiled, m.lanes, m.threads, m.mapping);
}

/// Finds the tiles of a rank's share, and what they weigh.
void lay_out(Plan& plan) {
    const Machine& m = plan.machine;
    const std::vector<std::int64_t> share = largest_share(plan);
    const Tiling tiling = tiling_of(plan, share, m.lanes);
    double slots = 0;
    int most_rows = 0;
    const auto add = [&](double tiles, int rows) {
        if (tiles == 0) return;
        most_rows = std::max(most_rows, rows);
        slots += tiles * (rows + 1) * m.lanes;
    };
    for (std::size_t g = 0; g < plan.groups.size(); ++g) {
        GroupPlan& p = plan.groups[g];
        const std::int64_t along = share[g] - tiling.across[g];
        p.along = std::min(p.rods, along * m.ranks);
        p.tiles = tiles_across(p, p.rods - p.along, m.lanes);
        add(static_cast<double>(tiles_across(p, tiling.across[g], m.lanes)), p.elements);
        int least = m.lanes, most = 1;
        for (const AlongTile& tile : tiling.along)
            for (const AlongTile::Part& part : tile.parts)
                if (part.group == static_cast<int>(g)) {
                    least = std::min(least, part.pieces);
                    most = std::max(most, part.pieces);
                }
        if (p.along > 0)
            p.pieces = most == 1       ? "whole"
                       : least == most ? fmt::format("in {} pieces each", most)
                                       : fmt::format("in {} to {} pieces", least, most);
    }
    double constants = 0;
    for (const AlongTile& tile : tiling.along) {
        add(1, tile.rows);
        constants += tile.rows * m.lanes * sizeof(Strands<1>::Element); // where rows repeat far less
    }
    plan.state_bytes += m.ranks * (slots * sizeof(Slot<1>) + constants) +
                        static_cast<double>(m.ranks) * m.threads * most_rows * sizeof(SlotLoad<1>) * m.lanes;
}

/// Bytes of frames that wait to be written together: as many as a rank's buffer holds of its share, but one at least.
double waiting_bytes(double frames, double frame_bytes, int ranks) {
    if (frames == 0) return 0;
    const double most =
        std::max(1.0, std::floor(static_cast<double>(FrameWriter::default_buffer_bytes) * ranks / frame_bytes));
    return std::min(frames, most) * frame_bytes;
}

/// Bytes of rods, and of their frames.
void add_bytes(Plan& plan, const OutputSpec& output, std::span<const RodGroup> groups) {
    double frame_values = 0, tip_values = 0, nodes = 0, lines = 0; // the last two of poly data
    const bool exposed = plan.acts_between_rods();
    for (const RodGroup& group : groups) {
        const auto of_all = [&](auto of_one) {
            return static_cast<double>(group.count()) * static_cast<double>(of_one);
        };
        plan.state_bytes += of_all(sizeof(LocalRod));
        plan.copy_bytes += of_all(group.slots()) * sizeof(Slot<1>);
        if (exposed)
            plan.state_bytes += of_all(group.exposed_slots()) * (Exposure::bytes_per_slot + SlotLoads::bytes_per_slot);
        frame_values += of_all(3 * group.slots() + (output.directors ? 9 * group.elements() + 3 * group.slots() : 0));
        nodes += of_all(group.body() ? 2 * group.body()->line.size() : static_cast<std::size_t>(group.slots()));
        lines += of_all(group.body() ? group.body()->line.size() : 1);
        tip_values += of_all(output.both_ends ? 6 : 3);
    }
    const double value_bytes = output.precision == Precision::single ? 4 : 8,
                 frames = plan.frames(plan.cadence.of("trajectory")), tips = plan.frames(plan.cadence.of("tips"));
    plan.output_bytes = value_bytes * (frames * frame_values + tips * tip_values);
    plan.frame_bytes = waiting_bytes(frames, value_bytes * frame_values, plan.machine.ranks) +
                       waiting_bytes(tips, value_bytes * tip_values, plan.machine.ranks);
    plan.vtp = output.writes_vtp(static_cast<std::int64_t>(nodes));
    if (plan.vtp) plan.output_bytes += frames * VtkSeries::frame_bytes(output, lines, nodes, exposed);
}

/// Wall time of the steps, s.
double predicted_seconds(const Plan& plan) {
    const double cores = plan.machine.ranks * std::min(plan.machine.threads, plan.machine.cores),
                 stages = static_cast<double>(scheme_of(plan.integrator).stages.size());
    double ns = stage_ns(plan, largest_share(plan), std::min(plan.machine.threads, plan.machine.cores)), seconds = 0;
    for (const auto& one : plan.physics) {
        ns += one->ns_per_element() * static_cast<double>(plan.elements) / cores;
        seconds += one->core_seconds(plan) / cores;
    }
    return ns * 1e-9 * stages * static_cast<double>(plan.steps) / plan.steps_at_once + seconds;
}

void note_doubts(Plan& plan, const CoreTables& scene, std::span<const RodGroup> groups) {
    const auto note = [&](std::vector<std::string> all) {
        std::move(all.begin(), all.end(), std::back_inserter(plan.notes));
    };
    note(uneven_outputs(plan, scene));
    note(doubts(scene, groups, plan.dt));
    if (plan.force_dt && !plan.pseudo_time && !is_implicit(plan.integrator) && plan.dt > plan.limit)
        note({fmt::format(
            "time.force_dt lets a step pass that is {} of its limit: the motion that sets the limit may gain energy "
            "without end, and a run is stopped only where rods break or pass through each other",
            share_text(plan.dt / plan.limit))});
    for (const auto& one : plan.physics) note(one->notes(plan, groups));
}

} // namespace

PhysicsPlan::Coupling Plan::coupling() const {
    auto most = PhysicsPlan::Coupling::none;
    for (const auto& one : physics) most = std::max(most, one->coupling());
    return most;
}

bool Plan::acts_between_rods() const {
    return std::any_of(physics.begin(), physics.end(), [](const auto& one) { return one->acts_between_rods(); });
}

StepWatch step_watch(const Plan& plan) {
    if (plan.pseudo_time || is_implicit(plan.integrator)) return {};
    double inertia = 1;
    std::vector<char> undamped, acted_on;
    for (const GroupPlan& group : plan.groups) {
        acted_on.push_back(!group.body.empty() && group.limits.front().dt < HUGE_VAL);
        inertia = std::min(inertia, group.effective_inertia());
        undamped.push_back(group.undamped && !group.inertia);
    }
    return {.dt = plan.dt,
            .stability = std::sqrt(inertia) * scheme_of(plan.integrator).stability,
            .stops = !plan.force_dt,
            .undamped = std::move(undamped),
            .acted_on = std::move(acted_on)};
}

Tiling tiling_of(const Plan& plan, std::span<const std::int64_t> counts, int lanes) {
    return choose_tiling(tiling_groups(plan, counts), lanes, plan.machine.threads, plan.machine.mapping);
}

std::vector<std::int64_t> largest_share(const Plan& plan) {
    std::vector<std::int64_t> share;
    for (const GroupPlan& p : plan.groups) share.push_back((p.rods + plan.machine.ranks - 1) / plan.machine.ranks);
    return share;
}

double stage_ns(const Plan& plan, std::span<const std::int64_t> counts, int threads) {
    const int lanes = plan.machine.lanes;
    const double wide = 8 * tile_time(lanes) / tile_time(8); // times of passes are those of eight lanes
    const Tiling tiling = choose_tiling(tiling_groups(plan, counts), lanes, plan.machine.threads, plan.machine.mapping);
    double total = 0, longest = 0;
    const auto add = [&](double tiles, double ns) {
        if (tiles == 0) return;
        total += tiles * ns;
        longest = std::max(longest, ns);
    };
    for (std::size_t g = 0; g < plan.groups.size(); ++g)
        add(static_cast<double>(tiles_across(plan.groups[g], tiling.across[g], lanes)),
            plan.groups[g].elements * wide * plan.groups[g].ns_per_element_step);
    for (const AlongTile& tile : tiling.along)
        add(1, tile.rows * wide * along_row * nth(plan.groups, tile.parts.front().group).ns_per_element_step);
    return std::max(total / threads, longest);
}

bool has_rods_of_files(std::span<const RodGroup> groups) {
    return std::any_of(groups.begin(), groups.end(), [](const RodGroup& group) { return group.places().from_file(); });
}

Plan make_plan(const CoreTables& scene, std::vector<std::shared_ptr<PhysicsPlan>> physics,
               std::span<const RodGroup> groups, const Machine& machine) {
    Plan plan{.title = scene.title, .machine = machine};
    plan.physics = std::move(physics);
    for (const RodGroup& group : groups) {
        const GroupPlan& p =
            plan.groups.emplace_back(plan_group(scene.time, group, plan.physics, plan.acts_between_rods()));
        plan.rods += p.rods;
        plan.elements += p.rods * p.elements;
    }
    plan.families = find_families(plan.groups);
    choose_lanes(plan, groups);
    lay_out(plan);
    choose_step(plan, scene);
    plan.cadence = cadence_of(scene.output, plan);
    plan.keeping = {scene.output.keep, scene.output.milestones};
    plan.observables = scene.output.observables;
    add_bytes(plan, scene.output, groups);
    plan.rod_bytes = plan.state_bytes;
    for (const auto& one : plan.physics) one->add_bytes(plan, groups);
    if (plan.copy_bytes > machine.ranks * most_copied_bytes) plan.copy_bytes = 0;
    plan.predicted_s = predicted_seconds(plan);
    note_doubts(plan, scene, groups);
    return plan;
}

} // namespace skein
