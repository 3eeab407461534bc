// A copy of all that the next steps depend on, in memory: what a checkpoint holds of this rank, to go back to and look
// at steps again.
#pragma once

#include "coupling/interaction.hpp"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace skein {

class StateCopy {
public:
    /// Room for the rods that this rank owns. `owners`: number of the distribution of rods over ranks that they are of.
    StateCopy(std::span<const RodGroup> groups, const Rods& rods, std::int64_t owners);

    /// Copies the state of the same rods. Collective if rods interact.
    void take(const Rods& rods, const Interactions& interactions, std::int64_t step);
    /// Into rods of the same owners. Collective where rods interact.
    void put_back(Rods& rods, const Interactions& interactions) const;
    /// Puts back rods alone.
    void put_back(Rods& rods) const;
    /// Restores the places of single rods that groups knew with these owners.
    void put_back_places(std::span<RodGroup> groups) const;
    std::int64_t step() const { return step_; }
    std::int64_t owners() const { return owners_; }
    const std::vector<LocalRod>& owned() const { return owned_; }
    /// Canonical state of owned()[i].
    std::span<const Slot<1>> state(std::size_t i) const {
        return {slots_.data() + first_[i], first_[i + 1] - first_[i]};
    }
    const RodBudget& budget(std::size_t i) const { return budgets_[i]; }
    std::span<const double> memory(std::size_t i) const {
        return memory_.empty() ? std::span<const double>() : memory_[i];
    }
    const std::vector<SavedNumbers>& saved() const { return kept_; }

private:
    std::int64_t owners_, step_ = -1;
    std::vector<LocalRod> owned_;
    std::vector<std::pair<std::size_t, Places>> places_; ///< of groups of which ranks may know their own rods alone
    std::vector<std::size_t> all_;                       ///< places in owned_
    std::vector<std::size_t> first_;                     ///< slot of each rod, and behind the last
    std::vector<Slot<1>> slots_;
    std::vector<RodBudget> budgets_;
    std::vector<std::vector<double>> memory_; ///< of each rod; none where passes remember nothing
    std::vector<SavedNumbers> kept_;
};

} // namespace skein
