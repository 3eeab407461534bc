// A copy of all that the next steps depend on, in memory: what a checkpoint holds of this rank, to go back to and look at steps
// again.
#pragma once

#include "simulation/interaction.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

class StateCopy {
public:
    /// All must outlive it.
    StateCopy(std::span<const RodGroup> groups, Rods& rods, const Interactions& interactions);

    /// Collective where rods interact.
    void take(std::int64_t step);
    void put_back() const;
    std::int64_t step() const { return step_; }
    /// Canonical state of local()[i].
    std::span<const Slot<1>> state(std::size_t i) const { return {slots_.data() + first_[i], first_[i + 1] - first_[i]}; }
    const RodWorks& works(std::size_t i) const { return works_[i]; }
    std::span<const double> memory(std::size_t i) const { return memory_.empty() ? std::span<const double>() : memory_[i]; }
    const std::vector<KeptNumbers>& kept() const { return kept_; }

private:
    Rods& rods_;
    const Interactions& interactions_;
    std::int64_t step_ = -1;
    std::vector<std::size_t> all_;   ///< places in local()
    std::vector<std::size_t> first_; ///< slot of each rod, and behind the last
    std::vector<Slot<1>> slots_;
    std::vector<RodWorks> works_;
    std::vector<std::vector<double>> memory_; ///< of each rod; none where passes remember nothing
    std::vector<KeptNumbers> kept_;
};

} // namespace skein
