#include "simulation/load_balance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {

namespace {

constexpr double least_gain = 0.03;       // of a step: less is lost in what measurements scatter by
constexpr double first_price = 0.1;       // s, of a migration before one has been measured
constexpr double units_per_second = 1e15; // of integral weights

/// Cost of a rod that no measurement has to do with, which others have at the next migration.
std::int64_t made_up(std::int64_t gid, std::int64_t migrations) {
    const std::uint64_t h = hash_end(hash_begin(gid / 4) ^ static_cast<std::uint64_t>(migrations) * 0x9e3779b97f4a7c15ull);
    return 1 + static_cast<std::int64_t>(h % 8);
}

} // namespace

LoadBalance::LoadBalance(const Communicator& comm, const Plan& plan, std::span<const RodGroup> groups, Balance when)
    : comm_(comm), groups_(groups), when_(comm.size() > 1 && plan.contact ? when : Balance::never), due_(when_ == Balance::always),
      price_(first_price) {
    for (const GroupPlan& group : plan.groups) predicted_.push_back(group.ns_per_element_step * group.elements);
}

std::vector<double> LoadBalance::costs(const Rods& rods, const Interactions& all) const {
    std::vector<double> costs = work_of(all, rods.local());
    for (std::size_t i = 0; i < costs.size(); ++i)
        costs[i] = pair_rate_ * costs[i] + rod_rate_ * predicted_[static_cast<std::size_t>(rods.local()[i].group)];
    return costs;
}

void LoadBalance::look(const Timers& timers, const Rods& rods, const Interactions& all, std::int64_t step, std::int64_t left) {
    if (when_ != Balance::automatic || due_) return;
    const double rods_s = timers.seconds(Phase::rods), pairs_s = timers.seconds(Phase::contacts);
    const double steps = static_cast<double>(step - step_before_);
    if (const bool measured = step_before_ >= 0 && steps > 0; measured) {
        const std::vector<double> pairs = work_of(all, rods.local());
        double passes = 0;
        for (const LocalRod& rod : rods.local()) passes += predicted_[static_cast<std::size_t>(rod.group)];
        const double sums[] = {rods_s - rods_before_, passes, pairs_s - pairs_before_,
                               std::accumulate(pairs.begin(), pairs.end(), 0.0)};
        double all_sums[4];
        for (int i = 0; i < 4; ++i) {
            const std::vector<double> of_ranks = comm_.all_gather(std::span(&sums[i], 1));
            all_sums[i] = std::accumulate(of_ranks.begin(), of_ranks.end(), 0.0);
        }
        rod_rate_ = all_sums[0] / (all_sums[1] * steps);
        pair_rate_ = all_sums[3] > 0 ? all_sums[2] / (all_sums[3] * steps) : 0;

        const std::vector<double> each = costs(rods, all);
        const double mine = std::accumulate(each.begin(), each.end(), 0.0);
        const std::vector<double> of_ranks = comm_.all_gather(std::span(&mine, 1));
        const double mean = std::accumulate(of_ranks.begin(), of_ranks.end(), 0.0) / comm_.size();
        const double most = *std::max_element(of_ranks.begin(), of_ranks.end());
        const double heaviest = comm_.max(each.empty() ? 0.0 : *std::max_element(each.begin(), each.end()));
        figures_.imbalance = most / mean;
        const double gain = most - mean - heaviest; // of a step: pieces are cut to within a rod
        const auto lasting = static_cast<double>(std::min(left, step - owned_since_));
        due_ = gain > least_gain * mean && gain * lasting > price_;
    }
    rods_before_ = rods_s, pairs_before_ = pairs_s, step_before_ = step;
}

std::vector<Assignment> LoadBalance::assign(const Rods& rods, const Interactions& all) const {
    const std::vector<double> cost = when_ == Balance::automatic ? costs(rods, all) : std::vector<double>();
    std::vector<WeighedRod> weighed(rods.local().size());
    std::vector<std::size_t> places(weighed.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    rods.read(places, Copy::canonical, 0, [&](int, std::size_t i, const RodCopy& rod) {
        const LocalRod& local = rods.local()[i];
        const Vec3d centre = 0.5 * (lane(rod.state.front().position, 0) + lane(rod.state.back().position, 0));
        weighed[i] = {local.gid, centre,
                      cost.empty() ? made_up(local.gid, figures_.migrations)
                                   : std::max<std::int64_t>(1, std::llround(units_per_second * cost[i]))};
    });
    return skein::assign(comm_, weighed);
}

void LoadBalance::moved(double seconds, std::int64_t bodies) {
    ++figures_.migrations;
    figures_.bodies += bodies;
    price_ = comm_.max(seconds);
    due_ = when_ == Balance::always;
    owned_since_ = std::max(step_before_, std::int64_t{0});
    step_before_ = -1;
}

} // namespace skein
