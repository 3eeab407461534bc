// Bodies on their way to other ranks: all that their next steps depend on goes along, at any time between passes over all of them.
#pragma once

#include "parallel/communicator.hpp"
#include "partition/partition.hpp"
#include "rod/rods.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

class Migration {
public:
    /// Sends the state of rods to the ranks that are to own them, and with it what `groups` know of single rods (see
    /// keep_own_rods). `assigned`: of rods.local(). Collective.
    Migration(const Communicator& comm, std::span<RodGroup> groups, const Rods& rods, std::span<const Assignment> assigned);

    /// Rods of this rank from now on, ordered by group and, within a group, along the curve.
    const std::vector<LocalRod>& owned() const { return owned_; }
    /// Bodies that have come from other ranks, on all of them.
    std::int64_t moved() const { return moved_; }
    /// As it was sent, of owned()[i].
    std::span<const Slot<1>> state(std::size_t i) const;
    /// Puts all into rods that are made of owned().
    void put_into(Rods& rods) const;

private:
    /// Of a rod: its place along the curve, number, sender, state, energy budget, memory of passes.
    struct Record {
        std::uint64_t key;
        std::int64_t gid;
        std::int64_t from;
        const double* numbers;
    };
    static constexpr std::size_t head = 3, budget = 4; ///< numbers before the state, and behind it

    std::span<const RodGroup> groups_;
    std::vector<std::vector<double>> arrived_; ///< by group
    std::vector<std::size_t> memory_;          ///< numbers of a rod, by group
    std::vector<Record> records_;              ///< of owned_
    std::vector<LocalRod> owned_;
    std::int64_t moved_ = 0;
};

} // namespace skein
