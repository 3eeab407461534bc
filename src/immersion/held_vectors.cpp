#include "immersion/held_vectors.hpp"

#include <algorithm>
#include <unordered_map>

namespace skein {

namespace {

void append(std::vector<double>& records, std::int64_t identity, const Vec3d& value) {
    records.insert(records.end(), {static_cast<double>(identity), value.x, value.y, value.z});
}
Vec3d value_of(std::span<const double> record) { return {record[1], record[2], record[3]}; }

} // namespace

void HeldVectors::settle(const Communicator& comm, std::span<const std::int64_t> identities) {
    std::unordered_map<std::int64_t, Vec3d> before;
    before.reserve(identities_.size());
    for (std::size_t m = 0; m < identities_.size(); ++m) before.emplace(identities_[m], values_[m]);
    identities_.assign(identities.begin(), identities.end());
    values_.assign(identities.size(), Vec3d{0, 0, 0});
    std::vector<std::size_t> strangers;
    for (std::size_t m = 0; m < identities_.size(); ++m)
        if (const auto found = before.find(identities_[m]); found != before.end()) {
            values_[m] = found->second;
            before.erase(found);
        } else strangers.push_back(m);
    if (comm.max(static_cast<std::int64_t>(before.size())) == 0) return; // no marker has left its rank
    std::vector<double> left;
    for (const auto& [identity, value] : before) append(left, identity, value);
    const std::vector<double> all = comm.all_gather(left);
    before.clear();
    for (std::size_t at = 0; at < all.size(); at += record)
        before.emplace(static_cast<std::int64_t>(all[at]), value_of(std::span(all).subspan(at, record)));
    for (const std::size_t m : strangers)
        if (const auto found = before.find(identities_[m]); found != before.end()) values_[m] = found->second;
}

std::vector<double> HeldVectors::saved(const Communicator& comm) const {
    std::vector<double> mine;
    for (std::size_t m = 0; m < identities_.size(); ++m) append(mine, identities_[m], values_[m]);
    const std::vector<double> all = comm.all_gather(mine);
    std::vector<std::size_t> order;
    for (std::size_t at = 0; at < all.size(); at += record) order.push_back(at);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return all[a] < all[b]; });
    std::vector<double> sorted;
    sorted.reserve(all.size());
    for (const std::size_t at : order) sorted.insert(sorted.end(), &all[at], &all[at] + record);
    return sorted;
}

void HeldVectors::restore(const Communicator& comm, std::span<const double> saved) {
    identities_.clear();
    values_.clear();
    if (!comm.root()) return; // settle() sends vectors to their ranks
    for (std::size_t at = 0; at + record <= saved.size(); at += record) {
        identities_.push_back(static_cast<std::int64_t>(saved[at]));
        values_.push_back(value_of(saved.subspan(at, record)));
    }
}

} // namespace skein
