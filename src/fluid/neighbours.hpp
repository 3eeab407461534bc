// Ranks with adjacent cells along y or along z.
#pragma once

#include "fluid/pencils.hpp"
#include "parallel/communicator.hpp"
#include "parallel/messages.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace skein {

/// Part of a message: numbers to or from a rank.
inline RepeatedMessages::Part message_part(int rank, std::span<double> numbers) {
    return {rank, std::as_writable_bytes(numbers)};
}

struct Neighbours {
    int below, above; ///< ranks; -1: none

    /// Neighbours along z.
    static Neighbours of_slabs(const Pencils& pencils, bool periodic) {
        return of(pencils.slab(), pencils.slabs(), periodic,
                  [&](int slab) { return pencils.rank_of(slab, pencils.share()); });
    }
    /// Neighbours along y.
    static Neighbours of_rows(const Pencils& pencils, bool periodic) {
        return of(pencils.share(), pencils.across(), periodic,
                  [&](int share) { return pencils.rank_of(pencils.slab(), share); });
    }

private:
    template <class Rank> static Neighbours of(int own, int count, bool periodic, Rank&& rank) {
        const auto next = [&](int at) {
            return at >= 0 && at < count ? rank(at) : periodic ? rank((at + count) % count) : -1;
        };
        return {next(own - 1), next(own + 1)};
    }
};

/// Parts of messages to both neighbours and from them.
class NeighbourParts {
public:
    using Numbers = std::span<double>;
    explicit NeighbourParts(const Neighbours& ranks) : ranks_(ranks) {}

    void add(Numbers lowest, Numbers uppermost, Numbers from_below, Numbers from_above) {
        // Two ranks may be neighbours on both sides, so messages must match in order: upwards first.
        if (ranks_.above >= 0) sent_.push_back(message_part(ranks_.above, uppermost));
        if (ranks_.below >= 0) received_.push_back(message_part(ranks_.below, from_below));
        if (ranks_.below >= 0) sent_.push_back(message_part(ranks_.below, lowest));
        if (ranks_.above >= 0) received_.push_back(message_part(ranks_.above, from_above));
    }
    RepeatedMessages messages(const Communicator& comm) const { return {comm, sent_, received_}; }

private:
    Neighbours ranks_;
    std::vector<RepeatedMessages::Part> sent_, received_;
};

} // namespace skein
