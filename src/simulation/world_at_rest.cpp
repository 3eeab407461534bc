// Forces of contacts and walls on bodies that were put where they are, by a step that is taken back.
#include "contact/static_friction.hpp"
#include "simulation/world.hpp"
#include "skein/core/index.hpp"

namespace skein {

namespace {

/// Restores the memory of an interaction that has not kept it. Collective.
void restore_changed(const Communicator& comm, Interaction& one, std::span<const SavedNumbers> before) {
    const SavedNumbers now = one.saved();
    for (const SavedNumbers& kept : before) {
        if (kept.name != now.name) continue;
        const bool changed = kept.numbers != now.numbers || kept.rows != now.rows;
        if (comm.max(static_cast<std::int64_t>(changed)) > 0) one.restore(kept);
    }
}

} // namespace

void World::evaluate_at_rest(double time, const Rates& rates) {
    if (!neighbourhood_ && !walls_) return;
    const std::unique_ptr<StateCopy> before = copy();
    std::vector<Slot<1>> state;
    for (std::size_t i = 0; i < before->owned().size(); ++i) {
        state.assign(before->state(i).begin(), before->state(i).end());
        for (Slot<1>& slot : state) {
            set_lane(slot.velocity, 0, Vec3d{0, 0, 0});
            set_lane(slot.spin, 0, Vec3d{0, 0, 0});
        }
        if (rates) rates(i, state);
        rods_->import_rod(i, state);
    }
    // Nothing moves, and regularised friction, which has springs for the length of a step, has none in so long a one.
    const Step step{.index = clock.done() + 1,
                    .dt = plan.dt,
                    .drift = 0,
                    .kick = long_step,
                    .time = time,
                    .kick_length = 0,
                    .slot = 0,
                    .completes = true,
                    .last = true,
                    .begin = time};
    for (const auto& interaction : interactions_) interaction->begin_evaluation();
    rods_->drift(step);
    if (neighbourhood_) add_loads(interactions_, *neighbourhood_, step, timers);
    rods_->kick(step, false);
    for (const auto& interaction : interactions_) interaction->watch(step);
    before->put_back(*rods_);
    for (const auto& interaction : interactions_) restore_changed(comm, *interaction, before->saved());
}

void World::show_solution(double time, const Rates& rates) {
    solved_ = time;
    evaluate_at_rest(time, rates);
}

} // namespace skein
