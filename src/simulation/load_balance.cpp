#include "simulation/load_balance.hpp"

#include "core/memory.hpp"
#include "physics/contact/contact_plan.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "simulation/machine.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace skein {

namespace {

constexpr double least_gain = 0.03;     // of a step: less is lost in what measurements scatter by
constexpr double share_of_looks = 0.01; // of the time of a run
constexpr double units = 1e15;          // of integral weights, over all ranks
constexpr double record_share = 1.5;    // of the memory of rods: records of those that stay, leave and come

/// Cost of a rod that no measurement has to do with, which others have at the next migration.
std::int64_t made_up(std::int64_t gid, std::int64_t migrations) {
    const std::uint64_t h =
        hash_end(hash_begin(gid / 4) ^ static_cast<std::uint64_t>(migrations) * 0x9e3779b97f4a7c15ull);
    return 1 + static_cast<std::int64_t>(h % 8);
}

double sum_of(std::span<const double> x) { return std::accumulate(x.begin(), x.end(), 0.0); }

/// Numbers of all ranks, as many of each. Collective.
std::vector<double> of_ranks(const Communicator& comm, std::span<const double> mine) {
    const std::vector<std::int64_t> counts(static_cast<std::size_t>(comm.size()),
                                           static_cast<std::int64_t>(mine.size()));
    std::vector<double> all(counts.size() * mine.size());
    comm.all_gather(mine, counts, all);
    return all;
}

/// Rods feel each other, and no fluid that knows where they are.
bool may_move_rods(const Plan& plan) {
    const auto* fluid = plan.find<FluidPlan>();
    return plan.has<ContactPlan>() && !(fluid && fluid->two_way());
}

} // namespace

LoadBalance::LoadBalance(const Communicator& comm, const Plan& plan, Balance when)
    : comm_(comm), when_(comm.size() > 1 && may_move_rods(plan) ? when : Balance::never),
      due_(when_ == Balance::always) {
    for (const GroupPlan& group : plan.groups) passes_.push_back(group.ns_per_element_step * group.elements);
    if (when_ == Balance::automatic) sharing_ = ranks_of_this_machine(comm_);
}

LoadBalance::Work LoadBalance::work_of_rods(const Rods& rods, const Interactions& all) const {
    Work work{work_of(all, rods.local()), {}};
    work.passes.reserve(work.pairs.size());
    for (const LocalRod& rod : rods.local()) work.passes.push_back(nth(passes_, rod.group));
    return work;
}

std::vector<double> LoadBalance::costs(const Work& work) const {
    std::vector<double> costs(work.pairs.size());
    for (std::size_t i = 0; i < costs.size(); ++i) costs[i] = pass_rate_ * work.passes[i] + pair_rate_ * work.pairs[i];
    return costs;
}

void LoadBalance::update(Timers& timers, const Rods& rods, const Interactions& all, std::int64_t step,
                         std::int64_t left) {
    if (when_ != Balance::automatic || due_ || ++skipped_ <= skip_) return;
    skipped_ = 0;
    const auto timing = timers.time(Phase::balance);
    double looked = 0;
    if (owned_since_ < 0) owned_since_ = step;
    const double rods_s = timers.seconds(Phase::rods), pairs_s = timers.seconds(Phase::contacts);
    if (step_before_ >= 0 && step > step_before_) {
        const double began = wall_seconds();
        const Work work = work_of_rods(rods, all);
        looked = wall_seconds() - began;
        const double mine[] = {rods_s - rods_before_, pairs_s - pairs_before_, sum_of(work.passes), sum_of(work.pairs)};
        double sums[4] = {};
        const std::vector<double> numbers = of_ranks(comm_, mine);
        for (std::size_t i = 0; i < numbers.size(); ++i) sums[i % 4] += numbers[i];
        const auto steps = static_cast<double>(step - step_before_);
        pass_rate_ = sums[0] / (sums[2] * steps);
        pair_rate_ = sums[3] > 0 ? sums[1] / (sums[3] * steps) : 0;
        decide(rods, work, step, left);
    }
    rods_before_ = rods_s;
    pairs_before_ = pairs_s;
    step_before_ = step;
    skip_ = static_cast<std::int64_t>(comm_.max(looked) / share_of_looks);
}

void LoadBalance::decide(const Rods& rods, const Work& work, std::int64_t step, std::int64_t left) {
    const std::vector<double> each = costs(work);
    const double mine[] = {sum_of(each), each.empty() ? 0 : *std::max_element(each.begin(), each.end()), price_};
    double mean = 0, most = 0, heaviest = 0, price = 0;
    const std::vector<double> numbers = of_ranks(comm_, mine);
    for (std::size_t r = 0; r < numbers.size(); r += 3) {
        mean += numbers[r] / comm_.size();
        most = std::max(most, numbers[r]);
        heaviest = std::max(heaviest, numbers[r + 1]);
        price = std::max(price, numbers[r + 2]);
    }
    figures_.imbalance = most / mean;
    const double gain = most - mean - heaviest; // of a step: pieces are cut to within a rod
    const auto lasting = static_cast<double>(std::min(left, step - owned_since_));
    due_ = gain > least_gain * mean && gain * lasting > price && memory_suffices(rods);
}

bool LoadBalance::memory_suffices(const Rods& rods) const {
    const double spare = free_memory() / sharing_ - record_share * static_cast<double>(rods.bytes());
    return comm_.min(spare) > 0;
}

std::vector<Assignment> LoadBalance::assign(std::span<const RodGroup> groups, const Rods& rods,
                                            const Interactions& all) const {
    const std::vector<double> cost =
        when_ == Balance::automatic ? costs(work_of_rods(rods, all)) : std::vector<double>();
    const double mine = sum_of(cost), whole = sum_of(of_ranks(comm_, std::span(&mine, 1)));
    std::vector<WeighedRod> weighed(rods.local().size());
    std::vector<std::size_t> places(weighed.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    rods.read(places, Copy::canonical, 0, [&](int, std::size_t i, const RodCopy& rod) {
        const LocalRod& local = rods.local()[i];
        const Vec3d centre = 0.5 * (lane(rod.state.front().position, 0) + lane(rod.state.back().position, 0));
        weighed[i] = {local.gid, centre,
                      cost.empty() ? made_up(local.gid, figures_.migrations)
                                   : std::max<std::int64_t>(1, std::llround(units * cost[i] / whole))};
    });
    // The first rod of a copy of an assembly stands for all of it.
    const SceneSlots scene(groups);
    if (!scene.has_kin()) return skein::assign(comm_, weighed);
    std::map<std::int64_t, WeighedRod> copies;
    for (const WeighedRod& rod : weighed) {
        const std::int64_t kin = scene.kin_of(rod.gid);
        WeighedRod& copy = copies.try_emplace(kin, WeighedRod{kin, rod.centre, 0}).first->second;
        if (kin == rod.gid) copy.centre = rod.centre;
        copy.weight += rod.weight;
    }
    std::vector<WeighedRod> together;
    for (const auto& [kin, copy] : copies) together.push_back(copy);
    const std::vector<Assignment> of_copies = skein::assign(comm_, together);
    std::map<std::int64_t, Assignment> by_kin;
    for (std::size_t i = 0; i < together.size(); ++i) by_kin.emplace(together[i].gid, of_copies[i]);
    std::vector<Assignment> assigned;
    for (const WeighedRod& rod : weighed) assigned.push_back(by_kin.at(scene.kin_of(rod.gid)));
    return assigned;
}

void LoadBalance::moved(double seconds, std::int64_t bodies, std::int64_t step) {
    figures_.migrations += bodies > 0 || when_ == Balance::always;
    figures_.bodies += bodies;
    price_ = seconds;
    due_ = when_ == Balance::always;
    owned_since_ = step;
    step_before_ = -1;
}

} // namespace skein
