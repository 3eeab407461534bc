// Bodies on their way to other ranks: all that their next steps depend on goes along, at any time between passes over
// all of them.
#pragma once

#include "parallel/communicator.hpp"
#include "partition/partition.hpp"
#include "tiles/rods.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

class Migration {
public:
    /// Sends the state of rods to the ranks that are to own them, and with it what `groups` know of single rods (see
    /// keep_own_rods). `assigned`: of rods.local(). `lanes`, `threads`: of the tiles. Collective.
    Migration(const Communicator& comm, std::span<RodGroup> groups, const Rods& rods,
              std::span<const Assignment> assigned, int lanes, int threads);

    /// Rods of this rank from now on, in the order of their tiles.
    const std::vector<LocalRod>& owned() const { return owned_; }
    /// State of owned()[i], as it was sent.
    std::span<const Slot<1>> state(std::size_t i) const;
    /// Puts all into rods that are made of owned().
    void put_into(Rods& rods) const;

    /// Bodies that would come to a rank that is not theirs, on all ranks. Collective.
    static std::int64_t count(const Communicator& comm, std::span<const Assignment> assigned);

private:
    /// Numbers of a rod on its way, by group: its place along the curve, gid, state, energy budget, memory of passes,
    /// and what places know of it.
    struct Layout {
        static constexpr std::size_t head = 2, budget = 4;
        std::size_t state = 0, memory = 0, places = 0;
        std::size_t length() const { return head + state + budget + memory + places; }
    };
    std::vector<Layout> layouts(const Communicator& comm, std::span<const RodGroup> groups, const Rods& rods) const;
    void find_owned(std::span<const RodGroup> groups, int lanes, int threads);
    void keep_places(std::span<RodGroup> groups) const;

    std::vector<Layout> layout_;          ///< by group
    std::vector<std::int64_t> first_gid_; ///< of each group
    std::vector<double> stay_, come_;     ///< rods of this rank, from itself and from others
    std::vector<LocalRod> owned_;
    std::vector<const double*> record_; ///< of owned_
};

} // namespace skein
