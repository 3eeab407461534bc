#include "simulation/neighbourhood.hpp"

#include <numeric>
#include <utility>

namespace skein {

Neighbourhood::Neighbourhood(const Communicator& comm, std::span<const RodGroup> groups, const Rods& rods,
                             std::shared_ptr<Exposure> exposure)
    : comm_(comm), rods_(rods), exposure_(std::move(exposure)) {
    for (const RodGroup& group : groups) all_rods_ += static_cast<std::size_t>(group.count());
    if (comm_.size() == 1) return;
    std::vector<double> mine;
    for (const LocalRod& rod : rods_.local()) mine.push_back(static_cast<double>(rod.gid));
    count_of_rank_ = comm_.all_gather(static_cast<std::int64_t>(mine.size()));
    std::vector<double> all(all_rods_);
    comm_.all_gather(mine, count_of_rank_, all);
    std::size_t at = 0;
    for (const std::int64_t count : count_of_rank_) {
        std::vector<std::int64_t>& gids = rods_of_rank_.emplace_back();
        for (std::int64_t i = 0; i < count; ++i) gids.push_back(static_cast<std::int64_t>(all[at++]));
    }
    if (!exposure_) return;
    const Capsules& capsules = exposure_->capsules;
    for (const auto& gids : rods_of_rank_) {
        std::int64_t slots = 0;
        for (const std::int64_t gid : gids)
            slots += capsules.first_slot[static_cast<std::size_t>(gid) + 1] - capsules.first_slot[static_cast<std::size_t>(gid)];
        slots_of_rank_.push_back(slots);
    }
    sent_.resize(static_cast<std::size_t>(slots_of_rank_[static_cast<std::size_t>(comm_.rank())]));
    received_.resize(static_cast<std::size_t>(std::accumulate(slots_of_rank_.begin(), slots_of_rank_.end(), std::int64_t{0})));
}

std::vector<std::uint8_t> Neighbourhood::owned() const {
    std::vector<std::uint8_t> owned;
    if (comm_.size() == 1) return owned;
    owned.assign(all_rods_, 0);
    for (const LocalRod& rod : rods_.local()) owned[static_cast<std::size_t>(rod.gid)] = 1;
    return owned;
}

void Neighbourhood::exchange() {
    Capsules& c = exposure_->capsules;
    const auto for_slots = [&](std::size_t rank, auto&& f) {
        for (const std::int64_t gid : rods_of_rank_[rank])
            for (auto slot = static_cast<std::size_t>(c.first_slot[static_cast<std::size_t>(gid)]);
                 slot < static_cast<std::size_t>(c.first_slot[static_cast<std::size_t>(gid) + 1]); ++slot)
                f(c.node[slot], c.motion[slot]);
    };
    const auto me = static_cast<std::size_t>(comm_.rank());
    CapsuleSlot* to = sent_.data();
    for_slots(me, [&](const CapsuleNode& node, const CapsuleMotion& motion) { *to++ = {node, motion}; });
    comm_.all_gather(std::as_bytes(std::span(sent_)), sizeof(CapsuleSlot), slots_of_rank_,
                     std::as_writable_bytes(std::span(received_)));
    const CapsuleSlot* from = received_.data();
    for (std::size_t rank = 0; rank < rods_of_rank_.size(); ++rank) {
        if (rank == me) {
            from += slots_of_rank_[rank];
            continue;
        }
        for_slots(rank, [&](CapsuleNode& node, CapsuleMotion& motion) {
            node = from->node, motion = from->motion;
            ++from;
        });
    }
}

void Neighbourhood::share(std::span<double> of_rod) const {
    if (comm_.size() == 1) return;
    std::vector<double> mine, all(all_rods_);
    for (const LocalRod& rod : rods_.local()) mine.push_back(of_rod[static_cast<std::size_t>(rod.gid)]);
    comm_.all_gather(mine, count_of_rank_, all);
    std::size_t at = 0;
    for (const auto& gids : rods_of_rank_)
        for (const std::int64_t gid : gids) of_rod[static_cast<std::size_t>(gid)] = all[at++];
}

} // namespace skein
