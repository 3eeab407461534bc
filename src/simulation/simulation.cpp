#include "simulation/simulation.hpp"

#include "diagnostics/energy_audit.hpp"
#include "diagnostics/observables.hpp"
#include "io/disk.hpp"
#include "partition/partition.hpp"
#include "scene/scene_file.hpp"
#include "simulation/make_rods.hpp"
#include "simulation/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>

namespace skein {

namespace {

constexpr double tick_seconds = 1;         ///< wall time between two agreements of all ranks
constexpr std::int64_t check_every = 64;   ///< steps between two looks for rods that have gone astray
constexpr std::int64_t tick_multiple = 64; ///< steps between ticks: fewer would cut visits short and look at rods more often

volatile std::sig_atomic_t stop_requested = 0;

std::int64_t multiple_after(std::int64_t step, std::int64_t every) { return (step / every + 1) * every; }

/// What decides the bits of a run: the scene's physics and the step, not how long it runs or what it writes.
std::string physics_json(SceneSpec scene, double dt) {
    scene.time = {.dt = dt, .integrator = scene.time.integrator, .damping = scene.time.damping};
    return scene_json(scene, true);
}

bool is_result(const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    return name == "summary.json" || name == "physics.json" || name == "observables.csv" || name == "rods.pvd" ||
           name == "walls.pvd" || (name.starts_with("contacts_") && name.ends_with(".csv")) || name.ends_with(".xdmf") ||
           name.ends_with(".h5") || name.ends_with(".tmp");
}

/// Results without a checkpoint may be written over only by the run that left them unfinished: same physics, no summary.
void refuse_to_overwrite(const std::string& directory, const std::string& physics) {
    const bool results =
        std::any_of(std::filesystem::directory_iterator(directory), {}, [](const auto& entry) { return is_result(entry.path()); });
    if (!results) return;
    const std::string record = directory + "/physics.json";
    const bool unfinished =
        !std::filesystem::exists(directory + "/summary.json") && std::filesystem::exists(record) && read_file(record) == physics;
    if (!unfinished)
        throw IoError("'" + directory +
                      "' holds results but no checkpoint to resume from; use --overwrite to start anew, or another --out");
    std::printf("No checkpoint in %s yet: starting again from the beginning\n", directory.c_str());
}

void remove_results(const std::string& directory) {
    for (const auto& entry : std::filesystem::directory_iterator(directory))
        if (is_result(entry.path()) && entry.is_regular_file()) std::filesystem::remove(entry.path());
}

} // namespace

void request_stop() { stop_requested = 1; }

Simulation::Simulation(const Communicator& comm, const Threads& threads, const SceneSpec& scene, std::vector<RodGroup> groups,
                       Plan plan, RunOptions options)
    : comm_(comm), threads_(threads), groups_(std::move(groups)), plan_(std::move(plan)),
      options_(std::move(options)), sets_{scene.output.observes("angular_momentum"), scene.output.observes("curvature"),
                                          scene.output.observes("knots")},
      physics_(physics_json(scene, plan_.dt)), started_(wall_seconds()), clock_(plan_.dt, 0, plan_.integrator) {
    const auto setup = timers_.time(Phase::setup);
    on_root(comm_, [&] {
        std::filesystem::create_directories(options_.out);
        lock_ = std::make_unique<DirectoryLock>(options_.out);
        if (options_.overwrite) {
            remove_results(options_.out);
            keep_vtk_frames(options_.out, -1, plan_.dt);
        }
    });
    Surroundings around = make_surroundings(plan_, groups_);
    rods_ = make_rods(plan_, groups_, partition(comm_, groups_), threads_, around);
    if (around.others || around.walls)
        interactions_ = std::make_unique<Interactions>(comm_, threads_, plan_, groups_, *rods_, around);

    const auto warn = [](const std::string& text) { std::fprintf(stderr, "warning: %s\n", text.c_str()); };
    const std::vector<std::string> kept = interactions_ ? interactions_->kept_names() : std::vector<std::string>();
    const auto found = read_checkpoint(comm_, options_.out, groups_, *rods_, physics_, warn, kept);
    if (found) {
        if (interactions_) interactions_->restore(found->kept);
        clock_ = Clock(plan_.dt, found->step, plan_.integrator);
        last_checkpoint_ = found->step;
        if (comm_.root())
            std::printf("Resuming from %s: step %lld, %.1f %% done%s\n", found->file.c_str(), static_cast<long long>(found->step),
                        100.0 * static_cast<double>(found->step) / static_cast<double>(plan_.steps),
                        plan_.audit && !found->audited_from ? "; it has no audit, which begins here" : "");
    } else {
        on_root(comm_, [&] {
            refuse_to_overwrite(options_.out, physics_);
            write_file(options_.out + "/physics.json", physics_);
        });
    }
    first_step_ = clock_.done();
    if (plan_.audit) begin_audit(found ? found->audited_from : std::nullopt);
    last_step_ = plan_.steps;
    if (options_.until > 0) last_step_ = std::min<std::int64_t>(last_step_, std::llround(options_.until / plan_.dt));
    if (options_.steps > 0) last_step_ = std::min(last_step_, options_.steps);
    open_outputs(scene);
    progress_ = std::make_unique<Progress>(comm_.root() && !options_.quiet, first_step_, last_step_, plan_.dt,
                                           static_cast<double>(plan_.elements));
}

Simulation::~Simulation() = default;

void Simulation::begin_audit(std::optional<double> audited_from) {
    audited_from_ = audited_from;
    if (audited_from_) return;
    audited_from_ = observed_energy(observe(comm_, threads_, groups_, *rods_, clock_.time(), clock_.lag()));
    for (std::size_t i = 0; i < rods_->local().size(); ++i) rods_->set_works(i, {}); // a damaged checkpoint may have left its own
}

std::uint64_t Simulation::digest() const { return comm_.sum_wrapping(rods_->digest()); }

void Simulation::advance(std::int64_t until) {
    const bool coupled = interactions_ && steps_together(plan_), together = coupled || options_.protocol == Protocol::synchronous;
    bool going = true;
    while (clock_.done() < until && going) {
        const std::int64_t next_check = (clock_.done() / check_every + 1) * check_every;
        const auto steps =
            coupled ? clock_.next(std::min(until, next_check)) : clock_.next(until, together ? 1 : Clock::largest_batch);
        const std::int64_t last = steps.back().index;
        const bool check = last == until || last >= next_check;
        const bool fit = coupled ? step_together(steps, check) : step_alone(steps, check);
        clock_.advance(steps);
        if (check && interactions_) interactions_->look_at_walls(steps.back());
        if (check && !told_limit_ && near_limit_.empty()) {
            near_limit_ = rods_->near_limit();
            if (!near_limit_.empty()) near_limit_ += fmt::format(" at step {}", clock_.done());
        }
        if (!fit) try {
                rods_->inspect(clock_.done(), plan_.dt);
                if (interactions_) interactions_->inspect(clock_.done());
            } catch (const NumericalError& e) {
                failure_ = e.what();
            } // the other ranks learn of it when they meet
        going = (together ? meet() : failure_.empty()) && !ended();
    }
}

bool Simulation::step_alone(std::span<const Step> steps, bool check) {
    const auto timing = timers_.time(Phase::rods);
    return rods_->visit(steps, check); // per tile: drift, forces, loads, kick
}

bool Simulation::step_together(std::span<const Step> steps, bool check) {
    const auto timed = [&](auto&& work) {
        const auto timing = timers_.time(Phase::rods);
        work();
    };
    bool fit = true;
    timed([&] { rods_->move(steps.front()); }); // per tile: drift
    for (std::size_t i = 0; i < steps.size(); ++i) {
        interactions_->meet(steps[i], timers_); // contacts
        timed([&] {                             // per tile: forces, loads, walls, kick; then the next drift
            if (i + 1 < steps.size()) rods_->act_and_move(steps[i], steps[i + 1]);
            else fit = rods_->act(steps[i], check);
        });
        interactions_->steer(steps[i], timers_); // servos
    }
    return fit && (!check || interactions_->fit());
}

bool Simulation::ended() const { return at_rest_ || (interactions_ && interactions_->finished()); }

void Simulation::look_for_rest() {
    at_rest_ = plan_.rest_speed > 0 && clock_.done() > 0 && last_sample_[observed_speed] < plan_.rest_speed;
}

bool Simulation::meet() {
    const auto timing = timers_.time(Phase::agree);
    return comm_.max(static_cast<std::int64_t>(!failure_.empty())) == 0;
}

RunResult Simulation::run() {
    if (first_step_ == 0) write_due();
    else if (plan_.rest_speed > 0 && first_step_ % plan_.cadence.series == 0) {
        last_sample_ = observables();
        look_for_rest();
    }
    Verdict verdict = Verdict::go_on;
    next_tick_ = clock_.done() + tick_multiple;
    setup_s_ = wall_seconds() - started_;
    while (clock_.done() < last_step_ && verdict == Verdict::go_on && !ended()) {
        advance(next_event());
        verdict = agree();
        write_due();
        progress_->show(clock_.done());
    }
    progress_->finish();
    checkpoint();

    const RunResult result{clock_.done() < last_step_ && !ended() ? Exit::limit : Exit::done, clock_.done(), digest()};
    write_summary(result);
    return result;
}

std::int64_t Simulation::next_event() const {
    std::int64_t next = std::min(last_step_, next_tick_);
    for (const std::int64_t every :
         {plan_.cadence.trajectory, plan_.cadence.tips, plan_.cadence.series, plan_.cadence.contacts, plan_.cadence.checkpoint})
        if (every > 0) next = std::min(next, multiple_after(clock_.done(), every));
    return next;
}

Simulation::Verdict Simulation::agree() {
    const auto timing = timers_.time(Phase::agree);
    const double wall = wall_seconds() - started_;
    const bool late = options_.walltime > 0 && wall > 0.98 * options_.walltime;
    const bool tells = (!near_limit_.empty() && !told_limit_) || (interactions_ && interactions_->passed());
    const Verdict mine = !failure_.empty()        ? Verdict::fail
                         : stop_requested || late ? Verdict::stop_at_limit
                         : tells                  ? Verdict::warn
                                                  : Verdict::go_on;
    auto verdict = static_cast<Verdict>(comm_.max(static_cast<std::int64_t>(mine)));
    if (verdict == Verdict::warn || verdict == Verdict::fail) {
        warn_of_limit();
        warn_of_overlap();
    }
    if (verdict == Verdict::fail) throw_failure();
    if (verdict == Verdict::warn) verdict = Verdict::go_on;
    if (clock_.done() >= next_tick_) {
        // As many steps as fit at the speed so far; root's figure for all.
        const double speed = static_cast<double>(clock_.done() - first_step_) / std::max(1e-9, wall - setup_s_);
        const auto visits = static_cast<std::int64_t>(std::min(1e9, speed * tick_seconds / tick_multiple));
        next_tick_ = clock_.done() + tick_multiple * comm_.broadcast(std::max<std::int64_t>(1, visits));
    }
    return verdict;
}

void Simulation::throw_failure() {
    progress_->finish();
    const double ratio = plan_.dt / plan_.limit;
    throw NumericalError(fmt::format(
        "{}\n  likely cause: dt is {:.3g} of the rest-state limit {:.4g} s{}\n  {}", comm_.first_text(failure_), ratio, plan_.limit,
        ratio > 0.95 ? ", too close to it; lower dt" : "; strains have grown beyond what it allows, or a load is too strong",
        last_checkpoint_ >= 0 ? fmt::format("the last good checkpoint is of step {}", last_checkpoint_)
                              : "there is no checkpoint yet"));
}

void Simulation::open_outputs(const SceneSpec& scene) {
    const auto frames = [&](FrameKind kind) {
        return std::make_unique<FrameWriter>(comm_, options_.out, kind, scene.output, groups_, *rods_, threads_, clock_.done(),
                                             plan_.title);
    };
    if (plan_.cadence.trajectory > 0) trajectory_ = frames(FrameKind::trajectory);
    if (plan_.cadence.tips > 0) tips_ = frames(FrameKind::tips);
    open_polydata(scene);
    if (plan_.cadence.series > 0)
        on_root(comm_, [&] { series_ = std::make_unique<SeriesFile>(options_.out + "/observables.csv", names(), clock_.done()); });
}

void Simulation::open_polydata(const SceneSpec& scene) {
    on_root(comm_, [&] { keep_vtk_frames(options_.out, clock_.done(), plan_.dt); });
    if (!plan_.vtp) return;
    VtkSeries::NodeForces forces;
    if (interactions_ && interactions_->rods_touch())
        forces = [this](std::int64_t gid, std::span<Vec3d> out) { interactions_->contact_forces(gid, out); };
    polydata_ = std::make_unique<VtkSeries>(comm_, options_.out, scene.output, groups_, *rods_, threads_, clock_.done(), plan_.dt,
                                            std::move(forces));
    if (interactions_ && interactions_->walls()) wall_meshes_ = std::make_unique<WallMeshes>(*interactions_->walls(), groups_);
}

void Simulation::write_polydata() {
    polydata_->write(clock_.done(), clock_.time(), clock_.lag());
    if (wall_meshes_ && (wall_meshes_->move() || clock_.done() == 0))
        polydata_->write_walls(clock_.done(), clock_.time(), wall_meshes_->at(clock_.time()));
}

void Simulation::write_due() {
    const auto due = [&](std::int64_t every) { return every > 0 && clock_.done() % every == 0; };
    if (due(plan_.cadence.series)) sample();
    {
        const auto timing = timers_.time(Phase::output);
        if (due(plan_.cadence.trajectory)) trajectory_->write(clock_.done(), clock_.time(), clock_.lag());
        if (polydata_ && due(plan_.cadence.trajectory)) write_polydata();
        if (due(plan_.cadence.tips)) tips_->write(clock_.done(), clock_.time(), clock_.lag());
        if (clock_.done() > 0 && due(plan_.cadence.contacts)) {
            const std::string table = interactions_->contact_table();
            on_root(comm_, [&] { write_file(fmt::format("{}/contacts_{:012d}.csv", options_.out, clock_.done()), table); });
        }
    }
    if (clock_.done() > 0 && due(plan_.cadence.checkpoint)) checkpoint();
}

std::vector<std::string> Simulation::names() const {
    auto all = observable_names(sets_);
    if (plan_.audit) all.insert(all.end(), std::begin(audit_names), std::end(audit_names));
    if (interactions_)
        for (std::string& name : interactions_->names()) all.push_back(std::move(name));
    if (plan_.gravity) all.emplace_back("potential[J]");
    return all;
}

std::vector<double> Simulation::observables() const {
    auto values = observe(comm_, threads_, groups_, *rods_, clock_.time(), clock_.lag(), sets_);
    if (plan_.audit) {
        const EnergyAudit a = audit_scene(comm_, *rods_, observed_energy(values));
        values.insert(values.end(), {a.loads, a.walls, a.dissipated, a.defect(*audited_from_)});
    }
    const Vec3d centre{values[observed_centre], values[observed_centre + 1], values[observed_centre + 2]};
    if (interactions_)
        for (const double x : interactions_->values()) values.push_back(x);
    if (plan_.gravity) values.push_back(-plan_.mass * dot(*plan_.gravity, centre));
    return values;
}

void Simulation::sample() {
    const auto timing = timers_.time(Phase::observe);
    last_sample_ = observables();
    warn_of_strain();
    look_for_rest();
    on_root(comm_, [&] { series_->append(clock_.done(), clock_.time(), last_sample_); });
}

void Simulation::warn(bool& told, bool bad, const std::string& text) {
    if (told || !bad) return;
    told = true;
    if (!comm_.root() || options_.quiet) return;
    progress_->finish();
    std::fprintf(stderr, "warning: step %lld: %s\n", static_cast<long long>(clock_.done()), text.c_str());
}

void Simulation::warn_of_limit() {
    const std::string text = comm_.first_text(near_limit_);
    warn(told_limit_, !text.empty(), text + (plan_.force_dt ? "" : "; beyond it the run is stopped: lower dt or time.e_min"));
}

void Simulation::warn_of_overlap() {
    if (!interactions_) return;
    bool told = false;
    const std::string text = interactions_->tell_of_overlaps();
    warn(told, !text.empty(), text);
}

void Simulation::warn_of_strain() {
    const double turn = last_sample_[observed_turn_per_cell], strain = last_sample_[observed_axial_strain];
    double room = HUGE_VAL; // to the lowest tension limit
    for (std::size_t g = 0; g < groups_.size(); ++g)
        room = std::min(room, plan_.groups[g].tension_limit - groups_[g].element[0].rest_stretch);
    warn(told_turn_, turn > 2,
         fmt::format("neighbouring elements turn by {:.3g} rad against each other, and 3 rad stops the run: use more elements",
                     turn));
    warn(
        told_strain_, strain > 0.7,
        fmt::format("an axial strain of {:.3g}: elements are shorter than 0.3 or well on the way to 3 times their length", strain));
    warn(told_tension_, strain > room,
         fmt::format("an axial strain of {:.3g} may be beyond the tension limit (plan): directors flip there", strain));
}

void Simulation::checkpoint() {
    if (last_checkpoint_ == clock_.done()) return;
    {
        const auto timing = timers_.time(Phase::output);
        for (FrameWriter* frames : {trajectory_.get(), tips_.get()})
            if (frames) frames->close_segment();
        if (plan_.cadence.series > 0) on_root(comm_, [&] { series_->flush(); });
    }
    if (!options_.checkpoint) return;
    const auto timing = timers_.time(Phase::checkpoint);
    CheckpointInfo info{clock_.done(), plan_.dt, digest(), physics_, {}, audited_from_};
    if (interactions_) info.kept = interactions_->kept();
    write_checkpoint(comm_, options_.out, groups_, *rods_, info);
    last_checkpoint_ = clock_.done();
}

void Simulation::write_summary(const RunResult& result) {
    const std::vector<double> values = observables();
    RunFigures figures{.plan = plan_,
                       .result = result,
                       .finished = result.step == plan_.steps || ended(),
                       .first_step = first_step_,
                       .protocol = steps_together(plan_) ? Protocol::synchronous : options_.protocol,
                       .wall_s = wall_seconds() - started_,
                       .names = names(),
                       .observables = values};
    for (std::size_t p = 0; p < phase_count; ++p) {
        const double mine = timers_.seconds(static_cast<Phase>(p));
        figures.phases.push_back(
            {comm_.min(mine), static_cast<double>(comm_.sum(std::llround(mine * 1e6))) * 1e-6 / comm_.size(), comm_.max(mine)});
    }
    figures.rod_bytes = comm_.sum(static_cast<std::int64_t>(rods_->bytes()));
    figures.resident_bytes = comm_.sum(resident_bytes());
    if (interactions_) figures.overlaps = interactions_->largest_overlaps();
    on_root(comm_, [&] {
        write_file(options_.out + "/summary.json", summary_json(figures));
        if (!options_.quiet) std::printf("%s", timing_table(figures).c_str());
    });
}

} // namespace skein
