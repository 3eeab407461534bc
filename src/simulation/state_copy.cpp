#include "simulation/state_copy.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <numeric>

namespace skein {

StateCopy::StateCopy(std::span<const RodGroup> groups, const Rods& rods, std::int64_t owners)
    : owners_(owners), owned_(rods.local().begin(), rods.local().end()), all_(owned_.size()), first_{0} {
    std::iota(all_.begin(), all_.end(), std::size_t{0});
    bool remembers = false;
    for (std::size_t i = 0; i < owned_.size(); ++i) {
        const LocalRod& rod = owned_[i];
        first_.push_back(first_.back() + static_cast<std::size_t>(nth(groups, rod.group).slots()));
        const bool opens = i == 0 || owned_[i - 1].group != rod.group;
        remembers = remembers || (opens && !rods.memory(i).empty());
    }
    slots_.resize(first_.back());
    budgets_.resize(owned_.size());
    if (remembers) memory_.resize(owned_.size());
    for (std::size_t g = 0; g < groups.size(); ++g)
        if (groups[g].places().listed()) places_.emplace_back(g, groups[g].places());
}

void StateCopy::take(const Rods& rods, const Interactions& interactions, std::int64_t step) {
    rods.read(all_, Copy::canonical, 0, [&](int, std::size_t i, const RodCopy& rod) {
        std::copy(rod.state.begin(), rod.state.end(), slots_.begin() + static_cast<std::ptrdiff_t>(first_[i]));
        budgets_[i] = rods.budget(i);
        if (!memory_.empty()) memory_[i] = rods.memory(i);
    });
    kept_ = skein::saved(interactions);
    step_ = step;
}

void StateCopy::put_back(Rods& rods) const {
    for (std::size_t i = 0; i < budgets_.size(); ++i) { // one by one: rods of a tile share what is put back
        rods.import_rod(i, state(i));
        rods.set_budget(i, budgets_[i]);
        if (!memory_.empty()) rods.set_memory(i, memory_[i]);
    }
}

void StateCopy::put_back(Rods& rods, const Interactions& interactions) const {
    put_back(rods);
    restore(interactions, kept_);
}

void StateCopy::put_back_places(std::span<RodGroup> groups) const {
    for (const auto& [group, places] : places_) groups[group].places() = places;
}

} // namespace skein
