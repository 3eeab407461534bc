#include "immersion/immersion.hpp"

#include "core/timer.hpp"
#include "immersion/body_surface.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace skein {

namespace {

bool some_markers_move(const std::vector<Obstacle>& obstacles) {
    return std::any_of(obstacles.begin(), obstacles.end(),
                       [](const Obstacle& o) { return o.moves() && !o.is_sharp(); });
}

/// Momentum over density of the fluid that moves with an obstacle, m^4/s, and its moment about the centre, m^5/s.
struct InnerFlow {
    Vec3d linear, angular;
};
InnerFlow inner_flow(const Obstacle& obstacle, const Solid& solid, double time) {
    const Mat3d axes = obstacle.axes_at(time);
    const Vec3d &spin = obstacle.angular_velocity, v = obstacle.velocity_at(time),
                arm = transpose_times(axes, solid.centre);
    const SymmetricMatrix about_centre = of_point(solid.centre);
    const Vec3d own = axes * spin;
    return {solid.volume * (v + cross(spin, arm)),
            solid.volume * (transpose_times(axes, solid.inertia * own + about_centre * own) + cross(arm, v))};
}

/// Point about which the couple on an obstacle is taken, m: of a cylinder the middle of its axis in the box.
Vec3d origin_at(const Obstacle& obstacle, const FluidGrid& grid, double time) {
    Vec3d at = obstacle.place_at(time);
    if (obstacle.kind == ObstacleKind::cylinder) at.z = 0.5 * (grid.lower.z + grid.upper().z);
    return at;
}

SharpBody sharp_body(const Obstacle& obstacle, const FluidGrid& grid) {
    return {.surface = obstacle.shape(),
            .motion = [obstacle, grid](double time) -> BodyMotion {
                return {origin_at(obstacle, grid, time), obstacle.velocity_at(time), obstacle.angular_velocity,
                        obstacle.axes_at(time)};
            },
            .moves = obstacle.moves()};
}

} // namespace

/// Surfaces act first, so that markers of rods feel the flow around them. Those of free bodies act where rods and
/// bodies have come to the end of a stage.
class Immersion::AllBodies final : public StageForcing {
public:
    explicit AllBodies(Immersion& of) : of_(of) {}
    void add_held_forces(const FlowStage& stage) override {
        of_.surfaces_->add_held_forces(stage);
        if (of_.has_markers()) of_.forcing_.add_held_forces(stage);
    }
    void sample(const FlowStage& stage) override {
        if (!of_.has_sharp_bodies()) of_.surfaces_->act(stage);
        else if (of_.balance_) of_.expect_rods(stage);
        if (!of_.has_markers()) return;
        if (!of_.has_sharp_bodies()) return of_.forcing_.sample(stage);
        FlowStage other = stage; // surfaces need the velocities at its begin
        for (std::size_t c = 0; c < 3; ++c) {
            scratch_[c].resize(of_.pencils_.layout().size());
            other.scratch[c] = scratch_[c].data();
        }
        of_.forcing_.sample(other);
    }
    void apply(const FlowStage& stage) override {
        if (stage.response) return apply_implicitly(stage);
        if (of_.has_sharp_bodies()) of_.surfaces_->act(stage);
        if (of_.has_markers()) of_.forcing_.apply(stage);
    }
    bool changed(int plane) const override {
        return of_.surfaces_->changed(plane) || (of_.has_markers() && of_.forcing_.changed(plane));
    }

private:
    void apply_implicitly(const FlowStage& stage) {
        std::vector<HeldForcing*> all{&*of_.surfaces_};
        if (of_.has_markers()) all.push_back(&of_.forcing_);
        sweep_held_forces(of_.comm_, stage, of_.sweeps_, of_.least_slip_, all);
    }

    Immersion& of_;
    std::array<AlignedVector<double>, 3> scratch_; ///< of markers beside free bodies with sharp surfaces
};

Immersion::~Immersion() = default;
StageForcing& Immersion::stage_forcing() { return all_ ? *all_ : forcing_; }

Immersion::Immersion(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                     const ForcingNumbers& numbers, std::vector<Obstacle> obstacles, std::unique_ptr<ImmersedRods> rods,
                     int across)
    : comm_(comm), grid_(grid), rank_(comm.rank()), pencils_(grid, comm.rank(), comm.size(), across),
      sweeps_(numbers.sweeps), least_slip_(numbers.slip), obstacles_(std::move(obstacles)), rods_(std::move(rods)),
      forcing_(
          comm, threads, grid, numbers, obstacles_.size() + (rods_ ? rods_->bodies() : 0),
          [this](double time, Markers& markers) { place(time, markers); }, rods_ || some_markers_move(obstacles_),
          across) {
    std::vector<SharpBody> sharp;
    for (std::size_t o = 0; o < obstacles_.size(); ++o) {
        about_centre_.emplace_back();
        if (obstacles_[o].is_sharp()) {
            sharp_.push_back(o);
            sharp.push_back(sharp_body(obstacles_[o], grid_));
        } else about_centre_.back() = obstacles_[o].markers(grid_);
        obstacle_markers_ += static_cast<std::int64_t>(about_centre_.back().size());
    }
    for (std::size_t b = 0; has_sharp_bodies() && b < rods_->sharp_bodies(); ++b) {
        sharp.push_back({.moves = true});
        if (const BodyShape* body = rods_->constants_of_sharp(b).body()) {
            sharp.back().surface = std::make_unique<PartsSurface>(*body);
            has_sharp_rigid_ = true;
        } else sharp.back().swept = std::make_unique<SweptSurface>(rods_->swept_surface_of(b, grid_));
    }
    set_parts();
    if (sharp.empty()) return;
    surfaces_.emplace(comm, threads, grid, numbers.kinematic_viscosity, std::move(sharp), across);
    all_ = std::make_unique<AllBodies>(*this);
    note_motions();
    take_motions();
}

void Immersion::set_parts() {
    const bool on_markers = rods_ && rods_->has_markers() && !rods_->single().empty();
    if (sharp_.size() == obstacles_.size() && !on_markers) return;
    forcing_.set_parts(obstacles_.size() + (rods_ ? rods_->single().size() : 0));
}

void Immersion::place(double time, Markers& markers) const {
    place_obstacles(time, markers);
    if (!rods_) return;
    const std::size_t others = markers.count();
    rods_->place(lag_, ahead_, static_cast<std::uint32_t>(obstacles_.size()), obstacle_markers_, markers);
    for (std::size_t m = others; m < markers.count(); ++m) {
        markers.place[m] += ahead_ * markers.velocity[m];
        markers.place[m] -= box_shift_;
    }
}

std::vector<Immersion::SharpMotion> Immersion::present_motions() const {
    // Each element as a body: place and velocity of its first node; a rod has its last node after them.
    struct Slot {
        BodyMotion body;
        Vec3d inner_velocity, inner_spin;
    };
    std::vector<std::vector<Slot>> of_own(rods_->rods().local().size());
    rods_->read(lag_, [&](int, std::size_t i, const RodCopy& rod) {
        if (rods_->sharp_number(i) < 0) return;
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            const Mat3d& frame = rod.frames[std::min(k, rod.frames.size() - 1)];
            const BodyMotion body{lane(rod.state[k].position, 0) - box_shift_, lane(rod.state[k].velocity, 0),
                                  transpose_times(frame, lane(rod.state[k].spin, 0)), frame};
            of_own[i].push_back({body, body.velocity, body.spin});
            if (!balance_ || !rods_->is_sharp_rod(i)) continue;
            const SharpSlot& slot = balance_->sharp_slot(i, k);
            of_own[i].back() = {body, slot.mean_velocity, slot.mean_spin};
        }
    });
    using Record = std::array<double, sizeof(Slot) / sizeof(double)>;
    std::vector<double> mine;
    for (std::size_t i = 0; i < of_own.size(); ++i)
        for (const Slot& slot : of_own[i]) {
            mine.push_back(static_cast<double>(rods_->sharp_number(i)));
            const auto numbers = std::bit_cast<Record>(slot);
            mine.insert(mine.end(), numbers.begin(), numbers.end());
        }
    const std::vector<double> all = comm_.all_gather(mine);
    std::vector<SharpMotion> motions(rods_->sharp_bodies());
    for (std::size_t at = 0; at < all.size(); at += 1 + std::tuple_size_v<Record>) {
        Record numbers;
        std::copy_n(&all[at + 1], numbers.size(), numbers.begin());
        const auto [slot, inner_velocity, inner_spin] = std::bit_cast<Slot>(numbers);
        SharpMotion& to = motions[static_cast<std::size_t>(all[at])];
        const bool first = to.rod.node.empty();
        if (first) to.body = slot;
        to.rod.node.push_back(slot.place - to.body.place);
        to.rod.velocity.push_back(slot.velocity);
        to.rod.frame.push_back(slot.axes);
        to.rod.spin.push_back(slot.spin);
        to.inner_velocity.push_back(inner_velocity);
        to.inner_spin.push_back(inner_spin);
    }
    for (SharpMotion& to : motions)
        if (to.rod.node.size() > 1) { // the last slot has no element
            to.rod.frame.pop_back();
            to.rod.spin.pop_back();
            to.inner_spin.pop_back();
        }
    return motions;
}

void Immersion::set_motion(std::size_t sharp, const SharpMotion& begin, const SharpMotion& end) {
    const std::size_t body = sharp_.size() + sharp;
    if (rods_->constants_of_sharp(sharp).body()) return surfaces_->set_motion(body, begin.body, end.body);
    RodMotion before = begin.rod;
    before.velocity = begin.inner_velocity;
    before.spin = begin.inner_spin;
    surfaces_->set_motion(body, begin.body.place, std::move(before), end.body.place, end.rod);
}

void Immersion::expect_rods(const FlowStage& stage) {
    if (!rods_->has_sharp_rods()) return;
    for (std::size_t b = 0; b < at_begin_.size(); ++b) {
        SharpMotion end = at_begin_[b];
        end.body.place += stage.dt * end.body.velocity;
        end.rod = end.rod.after(stage.dt);
        set_motion(b, at_begin_[b], end);
    }
    surfaces_->find_responses(stage);
}

void Immersion::note_motions() {
    if (has_sharp_bodies()) at_begin_ = present_motions();
}

void Immersion::take_motions() {
    if (!has_sharp_bodies()) return;
    std::vector<SharpMotion> now = present_motions();
    for (std::size_t b = 0; b < now.size(); ++b) {
        if (balance_ && ahead_ > 0 && !rods_->constants_of_sharp(b).body())
            now[b].rod.take_means(at_begin_[b].rod, now[b].body.place - at_begin_[b].body.place, ahead_);
        set_motion(b, at_begin_[b], now[b]);
    }
}

void Immersion::begin_step(double time, const std::array<const double*, 3>& velocity) {
    const Timers::Guard timing(seconds_);
    std::vector<RigidMotion> motions;
    if (has_sharp_rigid_) { // impulses of rods do not depend on the fluid within
        for (std::size_t b = 0; b < at_begin_.size(); ++b) set_motion(b, at_begin_[b], at_begin_[b]);
        motions = surfaces_->inner_motions(time, velocity);
    }
    balance_->begin_step(lag_,
                         [&](std::size_t i) { return motions[sharp_.size() + to_index(rods_->sharp_number(i))]; });
}

void Immersion::begin_stage(const ForceBalance::Stage& stage) {
    const Timers::Guard timing(seconds_);
    const std::size_t others = forcing_.markers().count() - rods_->count();
    balance_->begin_stage(
        stage, lag_, [&](std::size_t m) { return forcing_.response(others + m); },
        [&](std::size_t i) { return surfaces_->responses(sharp_.size() + to_index(rods_->sharp_number(i))); });
}

void Immersion::find_marker_velocities(const ForceBalance::Stage& stage) {
    const Timers::Guard timing(seconds_);
    balance_->find_mean_velocities(stage.length, lag_, of_rods(forcing_.markers().velocity));
}

void Immersion::end_stage(double density) {
    const Timers::Guard timing(seconds_);
    balance_->end_stage(
        of_rods(forcing_.changes()),
        [&](std::size_t i) -> ForceBalance::GivenBySurface {
            const GivenMomentum& given = surfaces_->given_in_stage(sharp_.size() + to_index(rods_->sharp_number(i)));
            return {density * given.linear, density * given.angular};
        },
        [&](std::size_t i) { return surfaces_->given_by_rod(sharp_.size() + to_index(rods_->sharp_number(i))); });
}

/// Each marker belongs to the rank that has its cell.
void Immersion::place_obstacles(double time, Markers& markers) const {
    const auto cell_of = [&](const Vec3d& place, int d) {
        const std::int64_t n = nth(grid_.cells, d);
        const auto cell =
            static_cast<std::int64_t>(std::floor((component_of(place, d) - component_of(grid_.lower, d)) / grid_.h));
        return static_cast<int>(grid_.periodic(d) ? (cell % n + n) % n : std::clamp<std::int64_t>(cell, 0, n - 1));
    };
    std::int64_t identity = 0;
    for (std::size_t o = 0; o < obstacles_.size(); ++o) {
        Vec3d centre = obstacles_[o].place_at(time);
        if (obstacles_[o].kind == ObstacleKind::cylinder) centre.z = 0;
        const Vec3d velocity = obstacles_[o].velocity_at(time), spin = obstacles_[o].angular_velocity;
        const bool turns = obstacles_[o].turns();
        const Vec3d origin = origin_at(obstacles_[o], grid_, time);
        const Mat3d at_start = obstacles_[o].axes_at(0), now = obstacles_[o].axes_at(time);
        for (const Vec3d& of_start : about_centre_[o]) {
            const Vec3d at = turns ? transpose_times(now, at_start * of_start) : of_start, place = centre + at;
            const std::int64_t own = identity++;
            if (pencils_.rank_of_cell(cell_of(place, 1), cell_of(place, 2)) != rank_) continue;
            markers.place.push_back(place);
            markers.velocity.push_back(turns ? velocity + cross(spin, at) : velocity);
            markers.identity.push_back(own);
            markers.body.push_back(static_cast<std::uint32_t>(o));
            if (!markers.has_parts) continue;
            markers.part.push_back(static_cast<std::uint32_t>(o));
            markers.arm.push_back(place - origin);
        }
    }
}

std::vector<double> Immersion::saved_held() const {
    std::vector<double> all = forcing_.held().saved(comm_);
    if (!surfaces_) return all;
    const std::vector<double> more = surfaces_->held().saved(comm_);
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

void Immersion::restore_held(std::span<const double> saved) {
    std::vector<double> of_markers, of_surfaces; // of negative identity
    for (std::size_t at = 0; at + HeldVectors::record <= saved.size(); at += HeldVectors::record) {
        const auto record = saved.subspan(at, HeldVectors::record);
        std::vector<double>& to = record[0] < 0 ? of_surfaces : of_markers;
        to.insert(to.end(), record.begin(), record.end());
    }
    forcing_.restore_held(of_markers);
    if (surfaces_) surfaces_->restore_held(of_surfaces);
}

void Immersion::begin_interval(double time) {
    forcing_.given().reset();
    if (forcing_.work()) forcing_.work()->reset();
    if (surfaces_) surfaces_->reset_given();
    if (surfaces_ && surfaces_->work()) surfaces_->work()->reset();
    from_ = time;
}

void Immersion::measure_work() {
    if (has_markers()) forcing_.measure_work();
    if (surfaces_) surfaces_->measure_work();
}

void Immersion::sum_loads() {
    forcing_.given().sum();
    if (forcing_.work()) forcing_.work()->sum();
    if (surfaces_ && surfaces_->work()) surfaces_->work()->sum();
}

std::optional<SurfaceWork> Immersion::power(double density, double time) const {
    SurfaceWork all;
    bool measured = false;
    for (const auto* work : {&forcing_.work(), surfaces_ ? &surfaces_->work() : nullptr})
        if (work && *work) all += (*work)->whole(), measured = true;
    if (!measured) return std::nullopt;
    const double per_time = time > from_ ? density / (time - from_) : 0;
    return SurfaceWork{per_time * all.given, per_time * all.lost};
}

const GivenMomentum* Immersion::given_by_sharp(std::size_t obstacle) const {
    const auto sharp = std::find(sharp_.begin(), sharp_.end(), obstacle);
    if (sharp == sharp_.end()) return nullptr;
    return &surfaces_->given()[static_cast<std::size_t>(sharp - sharp_.begin())];
}

Vec3d Immersion::given_by_obstacle(std::size_t obstacle) const {
    const GivenMomentum* const given = given_by_sharp(obstacle);
    return given ? given->linear : forcing_.given().of_body()[obstacle];
}

Vec3d Immersion::force_on_obstacle(std::size_t obstacle, double density, double time) const {
    if (!(time > from_)) return {0, 0, 0};
    const Obstacle& o = obstacles_[obstacle];
    // Fluid within the surface moves with the body, and its inertia is no force on the body.
    const Solid solid = o.solid(grid_);
    const Vec3d inside = inner_flow(o, solid, time).linear - inner_flow(o, solid, from_).linear;
    return (density / (time - from_)) * (inside - given_by_obstacle(obstacle));
}

Vec3d Immersion::couple_on_obstacle(std::size_t obstacle, double density, double time) const {
    const GivenMomentum* const sharp = given_by_sharp(obstacle);
    const GivenMomentum& given = sharp ? *sharp : forcing_.given().of_part()[obstacle];
    if (!(time > from_)) return Vec3d{0, 0, 0};
    const Obstacle& o = obstacles_[obstacle];
    const Solid solid = o.solid(grid_);
    Vec3d inside = inner_flow(o, solid, time).angular - inner_flow(o, solid, from_).angular;
    // A moment about a centre that moves changes by the momentum across its way too.
    constexpr int parts = 16;
    for (int p = 0; p < parts && norm(solid.centre) > 0; ++p) {
        const double at = from_ + (time - from_) * (p + 0.5) / parts;
        inside += ((time - from_) / parts) * cross(o.velocity_at(at), inner_flow(o, solid, at).linear);
    }
    return (density / (time - from_)) * (inside - given.angular);
}

Vec3d Immersion::force_on_rods(std::size_t group, double density, double time) const {
    if (!(time > from_)) return {0, 0, 0};
    Vec3d given = forcing_.given().of_body()[obstacles_.size() + group];
    for (std::size_t b = 0; b < rods_->sharp_bodies(); ++b)
        if (rods_->group_number_of_sharp(b) == group) given += surfaces_->given()[sharp_.size() + b].linear;
    return (-density / (time - from_)) * given;
}

Immersion::MeanLoad Immersion::load_on_single(std::size_t single, double density, double time) const {
    if (!(time > from_)) return {};
    GivenMomentum given;
    if (forcing_.given().has_parts()) given += forcing_.given().of_part()[obstacles_.size() + single];
    if (const std::int64_t sharp = rods_->sharp_number(rods_->single()[single]); sharp >= 0)
        given += surfaces_->given()[sharp_.size() + to_index(sharp)];
    const double per_time = -density / (time - from_);
    return {per_time * given.linear, per_time * given.angular};
}

} // namespace skein
