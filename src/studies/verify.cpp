#include "studies/verify.hpp"

#include "simulation/state_copy.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace skein {

namespace {

bool same_bits(std::span<const double> a, std::span<const double> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
        return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
    });
}

bool same_numbers(const SavedNumbers& computed, const SavedNumbers& written) {
    return same_bits(computed.numbers, written.numbers) && same_bits(computed.rows, written.rows);
}

std::span<const double> numbers(std::span<const Slot<1>> state) {
    return {reinterpret_cast<const double*>(state.data()), state.size() * slot_doubles};
}

} // namespace

std::string difference_to(Simulation& simulation, const std::string& checkpoint) {
    if (const std::string reason = simulation.failure(); !reason.empty()) return reason;
    World& world = simulation.world();
    const Communicator& comm = world.comm;
    const SceneTexts& texts = simulation.texts();
    const StateCopy computed = *world.copy();
    const double audited_from = simulation.observation().audited_from().value_or(0);
    const auto same_run = [&](const CheckpointInfo& info) {
        if (info.scene != texts.physics || info.ancestry != texts.ancestry || info.shift != world.clock.shift())
            throw InputError(checkpoint + ": is not of the run that the checkpoint before it is of");
    };
    const CheckpointInfo info =
        load_checkpoint(comm, checkpoint, world.groups, world.rods(), same_run, saved_names(world.interactions()));
    restore(world.interactions(), info.saved);
    const StateCopy written = *world.copy();

    constexpr std::int64_t nobody = std::numeric_limits<std::int64_t>::max();
    std::int64_t first = nobody, differing = 0;
    std::string mine;
    for (std::size_t i = 0; i < world.rods().local().size(); ++i) {
        const LocalRod& rod = world.rods().local()[i];
        const bool state = same_bits(numbers(computed.state(i)), numbers(written.state(i)));
        const RodBudget a = computed.budget(i), b = written.budget(i);
        const bool budget = same_bits(std::array{a.loads, a.walls, a.dissipated, a.fluid},
                                      std::array{b.loads, b.walls, b.dissipated, b.fluid});
        if (state && budget && same_bits(computed.memory(i), written.memory(i))) continue;
        ++differing;
        if (rod.gid >= first) continue;
        first = rod.gid;
        mine = fmt::format("rod {} of '{}' in its {}", rod.index, nth(world.groups, rod.group).name(),
                           !state   ? "state"
                           : budget ? "springs at walls"
                                    : "energy budget");
    }
    const std::int64_t all = comm.sum(differing), lowest = comm.min(first);
    std::string text;
    if (all > 0)
        text = fmt::format("{} of {} rods differ; the first is {}", all, world.plan.rods,
                           comm.first_text(first == lowest ? mine : std::string()));
    for (std::size_t i = 0; i < info.saved.size(); ++i)
        if (comm.max(static_cast<std::int64_t>(!same_numbers(computed.saved()[i], written.saved()[i]))) != 0)
            text += fmt::format("{}'{}' differ", text.empty() ? "" : "; ", info.saved[i].name);
    if (info.audited_from.value_or(0) != audited_from)
        text += fmt::format("{}the energy that the audit began with differs", text.empty() ? "" : "; ");
    return text;
}

} // namespace skein
