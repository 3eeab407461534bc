#include "immersion/direct_forcing.hpp"

#include "core/timer.hpp"
#include "immersion/sweep_shares.hpp"
#include "parallel/blocks.hpp"
#include "parallel/exact_sum.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

DirectForcing::DirectForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                             const ForcingNumbers& numbers, std::size_t bodies, Place place, bool moves, int across)
    : comm_(comm), threads_(threads), grid_(grid), numbers_(numbers), place_(std::move(place)), moves_(moves),
      planes_(comm, threads, grid, numbers.delta, across), given_(bodies, Vec3d{0, 0, 0}) {}

/// Markers where they are now, and their weights: by what a change of 1 at all markers does at each.
void DirectForcing::settle(const FlowStage& stage) {
    markers_.clear();
    place_(stage.time, markers_);
    planes_.settle(markers_.place, markers_.identity);
    for (std::vector<Vec3d>* of_markers : {&weight_, &found_, &difference_, &changes_})
        of_markers->resize(markers_.count());
    planes_.respond_to_ones(stage.scratch, weight_);
    const auto inverse = [](double sum) { return sum > 0 ? 1 / sum : 0; }; // 0: out of reach of all cells
    for_blocks(threads_, weight_.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t m = begin; m < end; ++m) {
            Vec3d& w = weight_[m];
            w = grid_.holds(markers_.place[m]) ? Vec3d{inverse(w.x), inverse(w.y), inverse(w.z)} : Vec3d{0, 0, 0};
        }
    });
    settled_ = true;
}

void DirectForcing::find_velocities(const FlowStage& stage) {
    stage.fill_beyond_walls([this](int plane) { return planes_.reaches_sides(plane); }, planes_.reaches_beyond());
    planes_.interpolate({stage.velocity[0], stage.velocity[1], stage.velocity[2]}, found_);
}

void DirectForcing::subtract_found() {
    for (std::size_t m = 0; m < difference_.size(); ++m) difference_[m] = markers_.velocity[m] - found_[m];
}

void DirectForcing::find_differences(const FlowStage& stage) {
    find_velocities(stage);
    subtract_found();
}

double DirectForcing::largest_difference() const {
    double most = 0;
    for (std::size_t m = 0; m < difference_.size(); ++m)
        if (norm(weight_[m]) > 0) most = std::max(most, norm(difference_[m]));
    return comm_.max(most);
}

void DirectForcing::add_given(const std::vector<Vec3d>& changes) {
    const double cell_volume = grid_.h * grid_.h * grid_.h;
    const Table table{changes.empty() ? nullptr : &changes[0].x,
                      changes.size(),
                      3,
                      sizeof(Vec3d) / sizeof(double),
                      given_.size(),
                      markers_.body.data()};
    const std::vector<double> sums = exact_sums(comm_, threads_, table);
    for (std::size_t b = 0; b < given_.size(); ++b)
        given_[b] += cell_volume * Vec3d{sums[3 * b], sums[3 * b + 1], sums[3 * b + 2]};
}

void DirectForcing::recall_held(std::span<const double> kept) {
    held_.restore(comm_, kept);
    settled_ = false;
}

void DirectForcing::hold(const FlowStage& stage) {
    const Timers::Guard timing(seconds_);
    if (!settled_ || moves_) {
        settle(stage);
        held_.settle(comm_, markers_.identity);
    }
    std::vector<Vec3d> pushes(held_.values().begin(), held_.values().end());
    for (Vec3d& push : pushes) push = stage.dt * push;
    planes_.spread(pushes, stage.velocity);
}

double DirectForcing::least_slips(std::span<const Vec3d> answer) const {
    std::vector<double> terms[2];
    for (std::size_t m = 0; m < answer.size(); ++m) {
        const Vec3d weighted = scale(weight_[m], answer[m]);
        terms[0].push_back(dot(weighted, difference_[m]));
        terms[1].push_back(dot(weighted, answer[m]));
    }
    const std::vector<double> sums = exact_sums(comm_, terms);
    return sums[1] > 0 ? sums[0] / sums[1] : 0;
}

void DirectForcing::apply_implicitly(const FlowStage& stage) {
    const std::span<Vec3d> force = held_.values();
    std::vector<Vec3d> push(markers_.count()), answer(markers_.count());
    find_differences(stage);
    for (int sweep = 0; sweep < numbers_.sweeps; ++sweep) {
        if (numbers_.slip > 0 && largest_difference() < numbers_.slip) break;
        for (std::size_t m = 0; m < push.size(); ++m) push[m] = scale(weight_[m], difference_[m]);
        stage.response->clear();
        planes_.spread(push, stage.scratch);
        stage.response->respond();
        planes_.interpolate({stage.scratch[0], stage.scratch[1], stage.scratch[2]}, answer);
        const double times = least_slips(answer);
        stage.response->add(times);
        for (std::size_t m = 0; m < push.size(); ++m) {
            difference_[m] -= times * answer[m];
            force[m] += (times / stage.dt) * push[m];
        }
    }
    slip_ = largest_difference();
    for (std::size_t m = 0; m < push.size(); ++m) push[m] = stage.dt * force[m];
    add_given(push);
}

DirectForcing::Answer DirectForcing::answer(std::size_t marker) const {
    const double h = grid_.h;
    if (!numbers_.penalty()) {
        // All sweeps together give from one to `sweeps` times what the first one does, three times at most, by how
        // rough the slip is: half way between, what is owed for the difference shrinks from stage to stage. theory.md
        // (90a), (90b)
        const double together = std::clamp(0.5 * numbers_.sweeps, 1.0, 0.5 * most_plain_sweeps);
        const Vec3d volume = (together * h * h * h) * weight_[marker];
        return {volume, scale(volume, found_[marker])};
    }
    const auto [left, set] = shares(marker);
    const Vec3d volume = (h * h * h) * scale(weight_[marker], set);
    return {volume, scale(volume, found_[marker]) -
                        (h * h * stage_ * numbers_.stiffness) * scale(left, held_.values()[marker])};
}

DirectForcing::SlipShares DirectForcing::shares(std::size_t marker) const {
    const double push = stage_ * (numbers_.damping + stage_ * numbers_.stiffness);
    const Vec3d inertia = grid_.h * weight_[marker]; // of the fluid that takes up the marker's velocity
    const Vec3d inverse{1 / (inertia.x + push), 1 / (inertia.y + push), 1 / (inertia.z + push)};
    return {scale(inertia, inverse), push * inverse};
}

void DirectForcing::meet(const FlowStage& stage) {
    const Timers::Guard timing(seconds_);
    stage_ = stage.dt;
    if (!settled_ || moves_) {
        settle(stage);
        if (numbers_.penalty()) held_.settle(comm_, markers_.identity);
    }
    find_velocities(stage);
}

void DirectForcing::apply_springs(const FlowStage& stage) {
    subtract_found();
    const std::span<Vec3d> lengths = held_.values();
    const double per_spacing = stage.dt / grid_.h,
                 back =
                     numbers_.stiffness / (numbers_.damping + stage.dt * numbers_.stiffness); // of springs alone, 1/s
    for (std::size_t m = 0; m < changes_.size(); ++m) {
        const auto [left, set] = shares(m);
        const Vec3d slip = scale(left, difference_[m]) - back * scale(set, lengths[m]); // theory.md (92a)
        lengths[m] += stage.dt * slip;
        changes_[m] = per_spacing * (numbers_.stiffness * lengths[m] + numbers_.damping * slip);
    }
    planes_.spread(changes_, stage.velocity);
    note_slip(stage);
    add_given(changes_);
}

void DirectForcing::note_slip(const FlowStage& stage) {
    if (!stage.ends_step) return;
    find_differences(stage);
    slip_ = largest_difference();
}

void DirectForcing::apply(const FlowStage& stage) {
    if (stage.response) return apply_implicitly(stage); // most of it is solves of the fluid
    const Timers::Guard timing(seconds_);
    if (numbers_.penalty()) return apply_springs(stage);
    std::vector<Vec3d> change(markers_.count());
    std::vector<std::vector<Vec3d>> of_sweeps; // where they have shares
    std::fill(changes_.begin(), changes_.end(), Vec3d{0, 0, 0});
    for (int sweep = 0; sweep < numbers_.sweeps; ++sweep) {
        if (sweep == 0) subtract_found(); // meet() has found them
        else find_differences(stage);
        if (numbers_.slip > 0 && largest_difference() < numbers_.slip) break;
        for (std::size_t m = 0; m < change.size(); ++m) {
            change[m] = scale(weight_[m], difference_[m]);
            changes_[m] += change[m];
        }
        planes_.spread(change, stage.velocity);
        if (numbers_.felt && numbers_.sweeps > most_plain_sweeps) of_sweeps.push_back(change);
    }
    if (of_sweeps.size() > most_plain_sweeps) {
        const std::vector<double> share = sweep_shares(static_cast<int>(of_sweeps.size()));
        std::fill(change.begin(), change.end(), Vec3d{0, 0, 0});
        for (std::size_t sweep = most_plain_sweeps; sweep < share.size(); ++sweep)
            for (std::size_t m = 0; m < change.size(); ++m) change[m] += (share[sweep] - 1) * of_sweeps[sweep][m];
        for (std::size_t m = 0; m < change.size(); ++m) changes_[m] += change[m];
        planes_.spread(change, stage.velocity);
    }
    note_slip(stage);
    add_given(changes_);
}

} // namespace skein
