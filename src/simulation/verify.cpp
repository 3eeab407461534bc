// Looks for what differs between a state that was computed again and the checkpoint that was written of it.
#include "simulation/simulation.hpp"
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

std::string Simulation::difference_to(const std::string& checkpoint) {
    if (const std::string reason = failure(); !reason.empty()) return reason;
    StateCopy computed(groups_, *rods_, owners_), written(computed);
    computed.take(*rods_, interactions_, clock_.done());
    const double audited_from = this->audited_from().value_or(0);
    const auto same_run = [&](const CheckpointInfo& info) {
        if (info.scene != physics_ || info.ancestry != ancestry_ || info.shift != clock_.shift())
            throw InputError(checkpoint + ": is not of the run that the checkpoint before it is of");
    };
    const auto kept = saved_names(interactions_);
    const CheckpointInfo info = load_checkpoint(comm_, checkpoint, groups_, *rods_, same_run, kept);
    restore(interactions_, info.saved);
    written.take(*rods_, interactions_, info.step);

    constexpr std::int64_t nobody = std::numeric_limits<std::int64_t>::max();
    std::int64_t first = nobody, differing = 0;
    std::string mine;
    for (std::size_t i = 0; i < rods_->local().size(); ++i) {
        const LocalRod& rod = rods_->local()[i];
        const bool state = same_bits(numbers(computed.state(i)), numbers(written.state(i)));
        const RodBudget a = computed.budget(i), b = written.budget(i);
        const bool budget =
            same_bits(std::array{a.loads, a.walls, a.dissipated}, std::array{b.loads, b.walls, b.dissipated});
        if (state && budget && same_bits(computed.memory(i), written.memory(i))) continue;
        ++differing;
        if (rod.gid >= first) continue;
        first = rod.gid;
        mine = fmt::format("rod {} of '{}' in its {}", rod.index, nth(groups_, rod.group).name(),
                           !state   ? "state"
                           : budget ? "springs at walls"
                                    : "energy budget");
    }
    const std::int64_t all = comm_.sum(differing), lowest = comm_.min(first);
    std::string text;
    if (all > 0)
        text = fmt::format("{} of {} rods differ; the first is {}", all, plan_.rods,
                           comm_.first_text(first == lowest ? mine : std::string()));
    for (std::size_t i = 0; i < info.saved.size(); ++i)
        if (comm_.max(static_cast<std::int64_t>(!same_numbers(computed.saved()[i], written.saved()[i]))) != 0)
            text += fmt::format("{}'{}' differ", text.empty() ? "" : "; ", info.saved[i].name);
    if (info.audited_from.value_or(0) != audited_from)
        text += fmt::format("{}the energy that the audit began with differs", text.empty() ? "" : "; ");
    return text;
}

} // namespace skein
