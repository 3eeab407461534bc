#include "simulation/caught_ends.hpp"

#include "core/rotation.hpp"
#include "mechanics/moving_ends.hpp"
#include "mechanics/rod_copies.hpp"

#include <algorithm>
#include <array>

namespace skein {

namespace {

/// An end as a stage begins.
struct EndNow {
    EndKind was, is;
    const EndMotion &led, &leads; ///< motion before and from now on
    Quaterniond frame;            ///< of its wall before, without its motion
    Vec3d node;                   ///< m
    Quaterniond element;          ///< frame of the element there
};

/// Place and frame from which the end's motion leads to where the end is now. A clamp with a half cell keeps its wall.
std::array<double, caught_end_numbers> caught(const RodGroup& group, std::int64_t index, const EndNow& end,
                                              double time) {
    const auto turn = [&](const EndMotion& motion) { return rotation(group.to_lab(index, motion.turn(time).value)); };
    const bool stays = end.was == EndKind::clamped && end.is == EndKind::clamped;
    const Vec3d place = end.node - group.to_lab(index, end.leads.displacement(time).value);
    const Quaterniond wall = stays ? end.frame * turn(end.led) : end.element, frame = wall * inverse(turn(end.leads));
    return {place.x, place.y, place.z, frame.w, frame.v.x, frame.v.y, frame.v.z};
}

} // namespace

std::vector<double> memory_in_stage(const RodSpec& before, const RodGroup& group, RodAtStage rod, const Clock& clock) {
    const RodSpec& now = group.spec();
    std::vector<double> memory = std::move(rod.initial);
    const std::size_t had = before.ends_caught() ? caught_ends_numbers : 0,
                      has = now.ends_caught() ? caught_ends_numbers : 0;
    const auto copy = [&](std::size_t from, std::size_t count, std::size_t to) {
        std::copy_n(rod.memory.begin() + static_cast<std::ptrdiff_t>(from), count,
                    memory.begin() + static_cast<std::ptrdiff_t>(to));
    };
    if (rod.memory.size() >= had && rod.memory.size() - had == memory.size() - has)
        copy(had, rod.memory.size() - had, has);
    if (has == 0) return memory;
    if (had > 0 && rod.memory.size() >= had) copy(0, had, 0);
    std::vector<Slot<1>> state(rod.state.begin(), rod.state.end());
    synchronise(group, state, clock.lag());
    const auto put = [&](std::size_t at, const EndNow& end) {
        const auto numbers = caught(group, rod.index, end, clock.time());
        std::copy(numbers.begin(), numbers.end(), memory.begin() + static_cast<std::ptrdiff_t>(at));
    };
    const auto frame = [&](std::size_t at) {
        return Quaterniond{memory[at + 3], {memory[at + 4], memory[at + 5], memory[at + 6]}};
    };
    const auto node = [&](std::size_t i) { return lane(state[i].position, 0); };
    const auto element = [&](std::size_t k) { return lane(state[k].director, 0); };
    constexpr std::size_t first = 0, second = caught_end_numbers;
    const std::size_t n = state.size() - 1;
    if (now.start_caught != before.start_caught)
        put(first, {before.start, now.start, before.start_motion, now.start_motion, frame(first), node(0), element(0)});
    if (now.end_caught != before.end_caught)
        put(second, {before.end, now.end, before.end_motion, now.end_motion, frame(second), node(n), element(n - 1)});
    return memory;
}

} // namespace skein
