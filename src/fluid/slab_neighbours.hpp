// Ranks whose slabs are beside a rank's own.
#pragma once

#include "parallel/communicator.hpp"
#include "parallel/messages.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace skein {

struct SlabNeighbours {
    int below, above; ///< ranks; -1: none

    SlabNeighbours(const Communicator& comm, bool periodic) : below(comm.rank() - 1), above(comm.rank() + 1) {
        if (below < 0 && periodic) below = comm.size() - 1;
        if (above == comm.size()) above = periodic ? 0 : -1;
    }
};

/// What is sent to both neighbours, and received from them.
class NeighbourParts {
public:
    using Numbers = std::span<double>;
    explicit NeighbourParts(const SlabNeighbours& ranks) : ranks_(ranks) {}

    void add(Numbers lowest, Numbers uppermost, Numbers from_below, Numbers from_above) {
        const auto part = [](int rank, Numbers numbers) { return RepeatedMessages::Part{rank, std::as_writable_bytes(numbers)}; };
        // Between two ranks that are both neighbours of each other messages match in order: upwards first.
        if (ranks_.above >= 0) sent_.push_back(part(ranks_.above, uppermost));
        if (ranks_.below >= 0) received_.push_back(part(ranks_.below, from_below));
        if (ranks_.below >= 0) sent_.push_back(part(ranks_.below, lowest));
        if (ranks_.above >= 0) received_.push_back(part(ranks_.above, from_above));
    }
    RepeatedMessages messages(const Communicator& comm) const { return {comm, sent_, received_}; }

private:
    SlabNeighbours ranks_;
    std::vector<RepeatedMessages::Part> sent_, received_;
};

} // namespace skein
