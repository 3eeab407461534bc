#include "simulation/state_copy.hpp"

#include <algorithm>
#include <numeric>

namespace skein {

StateCopy::StateCopy(std::span<const RodGroup> groups, Rods& rods, const Interactions& interactions)
    : rods_(rods), interactions_(interactions), all_(rods.local().size()), first_{0} {
    std::iota(all_.begin(), all_.end(), std::size_t{0});
    bool remembers = false;
    for (std::size_t i = 0; i < rods_.local().size(); ++i) {
        const LocalRod& rod = rods_.local()[i];
        first_.push_back(first_.back() + static_cast<std::size_t>(groups[static_cast<std::size_t>(rod.group)].slots()));
        const bool opens = i == 0 || rods_.local()[i - 1].group != rod.group;
        remembers = remembers || (opens && !rods_.memory(i).empty());
    }
    slots_.resize(first_.back());
    works_.resize(rods_.local().size());
    if (remembers) memory_.resize(rods_.local().size());
}

void StateCopy::take(std::int64_t step) {
    rods_.read(all_, Copy::canonical, 0, [&](int, std::size_t i, const RodCopy& rod) {
        std::copy(rod.state.begin(), rod.state.end(), slots_.begin() + static_cast<std::ptrdiff_t>(first_[i]));
        works_[i] = rods_.works(i);
        if (!memory_.empty()) memory_[i] = rods_.memory(i);
    });
    kept_ = skein::kept(interactions_);
    step_ = step;
}

void StateCopy::put_back() const {
    for (std::size_t i = 0; i < works_.size(); ++i) { // one by one: rods of a tile share what is put back
        rods_.import_rod(i, state(i));
        rods_.set_works(i, works_[i]);
        if (!memory_.empty()) rods_.set_memory(i, memory_[i]);
    }
    recall(interactions_, kept_);
}

} // namespace skein
