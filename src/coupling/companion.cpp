#include "coupling/companion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_map>

namespace skein {

static_assert(Companion::columns == 2 + slot_doubles);

Companion::States Companion::state_of(const Rods& rods) {
    States states(rods.local().size());
    std::vector<std::size_t> all(states.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    rods.read(all, Copy::canonical, 0,
              [&](int, std::size_t i, const RodCopy& rod) { states[i].assign(rod.state.begin(), rod.state.end()); });
    return states;
}

void Companion::enter(Rods& rods) {
    start_ = state_of(rods);
    if (state_.empty()) state_ = start_;
    for (std::size_t i = 0; i < state_.size(); ++i) rods.import_rod(i, state_[i]); // one by one: rods share tiles
    if (!remembers_) return;
    if (memory_.empty()) memory_ = memory_of(rods);
    for (std::size_t i = 0; i < memory_.size(); ++i) rods.set_memory(i, memory_[i]);
}

void Companion::leave(const Rods& rods) {
    end_ = state_of(rods);
    end_memory_ = memory_of(rods);
}

Companion::Memories Companion::memory_of(const Rods& rods) const {
    Memories all(remembers_ ? rods.local().size() : 0);
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = rods.memory(i);
    return all;
}

Companion::Apart Companion::apart(const Rods& rods) const {
    const States now = state_of(rods);
    Apart largest;
    for (std::size_t i = 0; i < now.size(); ++i)
        for (std::size_t k = 0; k < now[i].size(); ++k) {
            const Vec3d after = lane(now[i][k].position, 0) - lane(end_[i][k].position, 0);
            const Vec3d before = lane(start_[i][k].position, 0) - lane(state_[i][k].position, 0);
            largest.now = std::max(largest.now, dot(after, after));
            largest.change = std::max(largest.change, dot(after - before, after - before));
        }
    return {std::sqrt(largest.now), std::sqrt(largest.change)};
}

std::vector<double> Companion::rows(const Rods& rods) const {
    const States states = state_.empty() ? state_of(rods) : state_;
    std::vector<double> rows;
    for (std::size_t i = 0; i < states.size(); ++i)
        for (std::size_t k = 0; k < states[i].size(); ++k) {
            rows.push_back(static_cast<double>(rods.local()[i].gid));
            rows.push_back(static_cast<double>(k));
            const auto* numbers = reinterpret_cast<const double*>(&states[i][k]);
            rows.insert(rows.end(), numbers, numbers + slot_doubles);
        }
    const Memories memory = memory_.empty() ? memory_of(rods) : memory_;
    for (std::size_t i = 0; i < memory.size(); ++i)
        for (std::size_t at = 0; at < memory[i].size(); at += slot_doubles) {
            rows.push_back(static_cast<double>(rods.local()[i].gid));
            rows.push_back(-1 - static_cast<double>(at / slot_doubles));
            for (std::size_t n = at; n < at + slot_doubles; ++n)
                rows.push_back(n < memory[i].size() ? memory[i][n] : 0.0);
        }
    return rows;
}

void Companion::set(const Communicator& comm, const Rods& rods, std::span<const double> rows) {
    state_ = state_of(rods);
    memory_ = memory_of(rods);
    std::unordered_map<std::int64_t, std::size_t> own;
    for (std::size_t i = 0; i < state_.size(); ++i) own.emplace(rods.local()[i].gid, i);
    constexpr std::size_t block = columns << 14; // all ranks' rows at once may be too many
    const std::int64_t longest = comm.max(static_cast<std::int64_t>(rows.size()));
    for (std::size_t begin = 0; begin < static_cast<std::size_t>(longest); begin += block) {
        const std::size_t from = std::min(begin, rows.size()), size = std::min(block, rows.size() - from);
        const std::vector<double> all = comm.all_gather(rows.subspan(from, size));
        for (std::size_t at = 0; at + columns <= all.size(); at += columns) {
            const auto found = own.find(static_cast<std::int64_t>(all[at]));
            if (found == own.end()) continue;
            const auto numbers = std::span(all).subspan(at + 2, slot_doubles);
            if (all[at + 1] < 0) {
                if (!remembers_) continue;
                std::vector<double>& memory = memory_[found->second];
                const std::size_t first = slot_doubles * static_cast<std::size_t>(-1 - all[at + 1]);
                for (std::size_t n = first; n < std::min(first + slot_doubles, memory.size()); ++n)
                    memory[n] = numbers[n - first];
                continue;
            }
            const auto k = static_cast<std::size_t>(all[at + 1]);
            if (k < state_[found->second].size())
                std::copy(numbers.begin(), numbers.end(), reinterpret_cast<double*>(&state_[found->second][k]));
        }
    }
}

} // namespace skein
