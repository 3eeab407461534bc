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
      planes_(comm, threads, grid, numbers.delta, across), given_(comm, threads, grid.h * grid.h * grid.h, bodies) {}

bool DirectForcing::put_markers(const FlowStage& stage) {
    if (settled_ && !moves_) return false;
    markers_.clear();
    place_(stage.time, markers_);
    planes_.settle(markers_.place, markers_.identity);
    for (std::vector<Vec3d>* of_markers : {&weight_, &velocity_, &slip_, &changes_})
        of_markers->resize(markers_.count());
    return true;
}

void DirectForcing::find_weights(const FlowStage& stage) {
    planes_.respond_to_ones(stage.scratch, weight_);
    const auto inverse = [](double sum) { return sum > 0 ? 1 / sum : 0; }; // 0: no cell within reach
    for_blocks(threads_, weight_.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t m = begin; m < end; ++m) {
            Vec3d& w = weight_[m];
            w = grid_.holds(markers_.place[m]) ? Vec3d{inverse(w.x), inverse(w.y), inverse(w.z)} : Vec3d{0, 0, 0};
            if (!markers_.share.empty()) w = markers_.share[m] * w;
        }
    });
    settled_ = true;
    if (stage.response || numbers_.penalty()) held_.settle(comm_, markers_.identity);
}

void DirectForcing::find_velocities(const FlowStage& stage) {
    stage.fill_beyond_walls([this](int plane) { return planes_.reaches_sides(plane); }, planes_.reaches_beyond());
    planes_.interpolate({stage.velocity[0], stage.velocity[1], stage.velocity[2]}, velocity_);
}

void DirectForcing::subtract_velocities() {
    for (std::size_t m = 0; m < slip_.size(); ++m) slip_[m] = markers_.velocity[m] - velocity_[m];
}

void DirectForcing::find_slips(const FlowStage& stage) {
    find_velocities(stage);
    subtract_velocities();
}

double DirectForcing::largest_slip() const {
    double most = 0;
    for (std::size_t m = 0; m < slip_.size(); ++m)
        if (norm(weight_[m]) > 0) most = std::max(most, norm(slip_[m]));
    return comm_.max(most);
}

void DirectForcing::keep_work() {
    for (std::size_t m = 0; m < changes_.size(); ++m) {
        const Vec3d& v = markers_.velocity[m];
        const Vec3d middle = 0.5 * (at_begin_[m] + (v - slip_[m]));
        work_->add({dot(changes_[m], v), dot(changes_[m], v - middle)});
    }
    work_->end_stage();
}

void DirectForcing::restore_held(std::span<const double> saved) {
    held_.restore(comm_, saved);
    settled_ = false;
}

void DirectForcing::add_held_forces(const FlowStage& stage) {
    const Timers::Guard timing(seconds_);
    if (put_markers(stage)) find_weights(stage);
    std::vector<Vec3d> pushes(held_.values().begin(), held_.values().end());
    for (Vec3d& push : pushes) push = stage.dt * push;
    planes_.spread(pushes, stage.velocity);
}

void DirectForcing::push(const FlowStage& stage) {
    for (std::size_t m = 0; m < changes_.size(); ++m) changes_[m] = scale(weight_[m], slip_[m]);
    planes_.spread(changes_, stage.scratch);
}

void DirectForcing::find_response(const FlowStage& stage) {
    response_.resize(markers_.count());
    planes_.interpolate({stage.scratch[0], stage.scratch[1], stage.scratch[2]}, response_);
}

void DirectForcing::add_terms(std::array<std::vector<double>, 2>& terms) const {
    for (std::size_t m = 0; m < response_.size(); ++m) {
        const Vec3d weighted = scale(weight_[m], response_[m]);
        terms[0].push_back(dot(weighted, slip_[m]));
        terms[1].push_back(dot(weighted, response_[m]));
    }
}

void DirectForcing::take(double times, const FlowStage& stage) {
    const std::span<Vec3d> force = held_.values();
    for (std::size_t m = 0; m < force.size(); ++m) {
        slip_[m] -= times * response_[m];
        force[m] += (times / stage.dt) * changes_[m];
    }
}

void DirectForcing::end_sweeps(const FlowStage& stage) {
    largest_slip_ = largest_slip();
    for (std::size_t m = 0; m < changes_.size(); ++m) changes_[m] = stage.dt * held_.values()[m];
    given_.keep(changes_, markers_);
    if (!work_) return;
    for (std::size_t m = 0; m < changes_.size(); ++m)
        work_->add({dot(changes_[m], markers_.velocity[m]), dot(changes_[m], slip_[m])});
    work_->end_stage();
}

MarkerResponse DirectForcing::response(std::size_t marker) const {
    const double h = grid_.h;
    if (!numbers_.penalty()) {
        // All sweeps together give one to `sweeps` times the first one's change, at most three times, by the roughness
        // of the slip. With the mean of both, residual impulses shrink from stage to stage. theory.md (90a), (90b)
        const double together = std::clamp(0.5 * numbers_.sweeps, 1.0, 0.5 * most_plain_sweeps);
        const Vec3d volume = (together * h * h * h) * weight_[marker];
        return {volume, scale(volume, velocity_[marker])};
    }
    const auto [left, set] = shares(marker);
    const Vec3d volume = (h * h * h) * scale(weight_[marker], set);
    return {volume, scale(volume, velocity_[marker]) -
                        (h * h * stage_dt_ * numbers_.stiffness) * scale(left, held_.values()[marker])};
}

DirectForcing::SlipShares DirectForcing::shares(std::size_t marker) const {
    const double push = stage_dt_ * (numbers_.damping + stage_dt_ * numbers_.stiffness);
    const Vec3d inertia = grid_.h * weight_[marker]; // fluid that takes the marker's velocity
    const Vec3d inverse{1 / (inertia.x + push), 1 / (inertia.y + push), 1 / (inertia.z + push)};
    return {scale(inertia, inverse), push * inverse};
}

void DirectForcing::sample(const FlowStage& stage) {
    const Timers::Guard timing(seconds_);
    stage_dt_ = stage.dt;
    const bool moved = put_markers(stage);
    if (work_) {
        at_begin_.resize(markers_.count());
        planes_.interpolate(stage.begin, at_begin_);
    }
    if (moved) find_weights(stage);
    find_velocities(stage);
}

void DirectForcing::apply_springs(const FlowStage& stage) {
    subtract_velocities();
    const std::span<Vec3d> lengths = held_.values();
    const double per_spacing = stage.dt / grid_.h,
                 rate = numbers_.stiffness / (numbers_.damping + stage.dt * numbers_.stiffness); // springs alone, 1/s
    for (std::size_t m = 0; m < changes_.size(); ++m) {
        const auto [left, set] = shares(m);
        const Vec3d slip = scale(left, slip_[m]) - rate * scale(set, lengths[m]); // theory.md (92a)
        lengths[m] += stage.dt * slip;
        changes_[m] = per_spacing * (numbers_.stiffness * lengths[m] + numbers_.damping * slip);
    }
    planes_.spread(changes_, stage.velocity);
}

void DirectForcing::apply_sweeps(const FlowStage& stage) {
    const bool scaled = numbers_.two_way && numbers_.sweeps > most_plain_sweeps;
    std::vector<Vec3d> change(markers_.count());
    std::vector<std::vector<Vec3d>> sweeps; // their changes, if they are scaled
    std::fill(changes_.begin(), changes_.end(), Vec3d{0, 0, 0});
    for (int sweep = 0; sweep < numbers_.sweeps; ++sweep) {
        if (sweep == 0) subtract_velocities(); // sample() has interpolated them
        else find_slips(stage);
        if (numbers_.slip > 0 && largest_slip() < numbers_.slip) break;
        for (std::size_t m = 0; m < change.size(); ++m) {
            change[m] = scale(weight_[m], slip_[m]);
            changes_[m] += change[m];
        }
        planes_.spread(change, stage.velocity);
        if (scaled) sweeps.push_back(change);
    }
    if (sweeps.size() > most_plain_sweeps) rescale(sweeps, stage);
}

void DirectForcing::rescale(const std::vector<std::vector<Vec3d>>& sweeps, const FlowStage& stage) {
    const std::vector<double> share = sweep_shares(static_cast<int>(sweeps.size()));
    std::vector<Vec3d> change(markers_.count(), Vec3d{0, 0, 0});
    for (std::size_t sweep = most_plain_sweeps; sweep < share.size(); ++sweep)
        for (std::size_t m = 0; m < change.size(); ++m) change[m] += (share[sweep] - 1) * sweeps[sweep][m];
    for (std::size_t m = 0; m < change.size(); ++m) changes_[m] += change[m];
    planes_.spread(change, stage.velocity);
}

void DirectForcing::apply(const FlowStage& stage) {
    if (stage.response) { // counts as time of the fluid, which solves most of it
        HeldForcing* const markers[] = {this};
        return sweep_held_forces(comm_, stage, numbers_.sweeps, numbers_.slip, markers);
    }
    const Timers::Guard timing(seconds_);
    if (numbers_.penalty()) apply_springs(stage);
    else apply_sweeps(stage);
    if (work_ || stage.ends_step) find_slips(stage);
    if (stage.ends_step) largest_slip_ = largest_slip();
    if (work_) keep_work();
    given_.keep(changes_, markers_);
}

} // namespace skein
