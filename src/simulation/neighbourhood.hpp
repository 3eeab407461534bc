// The boundary between ranks: who owns which body, and what ranks send each other of them in every step. Every rank holds the
// exposure of the whole scene.
#pragma once

#include "contact/exposure.hpp"
#include "parallel/communicator.hpp"
#include "rod/rods.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace skein {

class Neighbourhood {
public:
    /// `exposure`: of all rods; null where nothing looks at it. Collective.
    Neighbourhood(const Communicator& comm, std::span<const RodGroup> groups, const Rods& rods, std::shared_ptr<Exposure> exposure);

    /// The exposure of own rods goes to all ranks, and that of theirs comes. Collective.
    void exchange();
    bool exchanges() const { return exposure_ && comm_.size() > 1; }

    /// Not 0 for rods of this rank, by gid; none where it owns all.
    std::vector<std::uint8_t> owned() const;
    std::size_t all_rods() const { return all_rods_; }
    /// Numbers by gid: those of own rods go to all ranks, and theirs come. Collective.
    void share(std::span<double> of_rod) const;

private:
    const Communicator comm_;
    const Rods& rods_;
    std::shared_ptr<Exposure> exposure_;
    std::size_t all_rods_ = 0;
    // Of several ranks: rods of each, and their slots, in the order in which they are sent.
    std::vector<std::vector<std::int64_t>> rods_of_rank_;
    std::vector<std::int64_t> count_of_rank_, slots_of_rank_;
    std::vector<CapsuleSlot> sent_, received_;
};

} // namespace skein
