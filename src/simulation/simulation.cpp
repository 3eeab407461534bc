#include "simulation/simulation.hpp"

#include "core/memory.hpp"
#include "core/stop.hpp"
#include "diagnostics/energy_audit.hpp"
#include "diagnostics/observables.hpp"
#include "io/disk.hpp"
#include "kernels/kernels.hpp"
#include "partition/partition.hpp"
#include "scene/plane_numbers.hpp"
#include "scene/scene_rebuild.hpp"
#include "simulation/branch.hpp"
#include "simulation/machine.hpp"
#include "simulation/migration.hpp"
#include "simulation/start_check.hpp"
#include "simulation/state_copy.hpp"
#include "simulation/summary.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <system_error>

namespace skein {

namespace {

constexpr double tick_seconds = 1;       ///< wall time between two agreements of all ranks
constexpr std::int64_t check_every = 64; ///< steps between two looks for rods whose state is invalid
constexpr std::int64_t tick_multiple =
    64; ///< steps between ticks: fewer would cut visits short and look at rods more often

/// The first step from `step` on at which all of the scene stands at one time.
std::int64_t whole_event(std::int64_t step, std::int64_t every) { return (step + every - 1) / every * every; }

/// Refuses rods that do not fit, before any is made: the system may end a process that takes too much without a word.
/// Of all ranks alike; those of one machine take from the same memory.
void require_memory(const Communicator& comm, const Plan& plan) {
    const auto sharing = static_cast<double>(ranks_of_this_machine(comm));
    const double needed = (plan.state_bytes + plan.frame_bytes) / comm.size(), there = free_memory() / sharing;
    std::string message;
    if (needed > there)
        message = fmt::format(
            "{} rods with {} elements need {:.3g} GB on {}, of which {:.3g} GB are free; fewer rods or more machines "
            "would do",
            plan.rods, plan.elements, 1e-9 * needed * sharing, host_name(), 1e-9 * there * sharing);
    message = comm.first_text(message);
    if (!message.empty()) throw InputError(message);
}

/// True where the directory of results has checkpoints, which a run goes on from. Collective.
bool goes_on(const Communicator& comm, const RunOptions& options) {
    bool some = false;
    on_root(comm, [&] {
        std::error_code error; // opening the directory reports what is wrong with it
        some = !options.overwrite && std::filesystem::is_directory(options.out, error) &&
               !numbered_files(options.out, "checkpoint_", ".h5").empty();
    });
    return comm.max(static_cast<std::int64_t>(some)) != 0;
}

} // namespace

Simulation::Simulation(const Communicator& comm, const Threads& threads, const SceneSpec& scene,
                       std::vector<RodGroup> groups, Plan plan, RunOptions options)
    : comm_(comm), threads_(threads), groups_(std::move(groups)), plan_(std::move(plan)),
      options_(std::move(options)), sets_{scene.output.observes("angular_momentum"), scene.output.observes("curvature"),
                                          scene.output.observes("knots"), scene.output.observes("order")},
      physics_(physics_json(with_plane_numbers(with_stiffnesses(scene, groups_), groups_), groups_, plan_.dt)),
      settings_(settings_json(scene)), output_(output_json(scene)),
      started_(options_.began > 0 ? options_.began : wall_seconds()),
      checkpoints_(plan_.cadence.checkpoint_wall, started_, plan_.state_bytes / plan_.machine.ranks),
      balance_(comm_, plan_, options_.balance), clock_(plan_.dt, 0, plan_.integrator) {
    timers_.add(Phase::setup, wall_seconds() - started_); // reading of the scene and of its rods
    const auto setup = timers_.time(Phase::setup);
    const bool writes = !options_.out.empty();
    require_memory(comm_, plan_);
    if (has_rods_of_files(groups_))
        if (const std::string fault = comm_.first_text(fault_of_read_rods(scene, plan_, groups_)); !fault.empty())
            throw InputError(fault);
    if (plan_.relax) settling_.emplace(plan_.relax_tolerance);
    std::vector<LocalRod> own = partition(comm_, groups_);
    keep_own_rods(comm_, groups_, own);
    const double began = wall_seconds();
    const std::shared_ptr<Exposure> exposure = make_bodies(own);
    balance_.expect(2 * (wall_seconds() - began)); // making them anew, and sending them
    if (options_.from.empty() && scene.start.from.empty() && !goes_on(comm_, options_))
        refuse_start(comm_, threads_, plan_, groups_, *rods_, exposure.get(), neighbourhood_.get());
    on_root(comm_, [&] {
        if (writes) directory_ = std::make_unique<ResultsDirectory>(options_.out, options_.overwrite);
    });

    std::vector<std::string> kept = saved_names(interactions_);
    if (settling_) kept.emplace_back(Settling::saved_name);
    std::optional<CheckpointInfo> found;
    if (writes) found = read_checkpoint(comm_, options_.out, groups_, *rods_, physics_, print_warning, kept);
    else if (!options_.from.empty())
        found = load_checkpoint(
            comm_, options_.from, groups_, *rods_, [](const CheckpointInfo&) {}, kept);
    const bool resumes = found.has_value();
    if (!resumes && !scene.start.from.empty())
        found = begin_branch(comm_, {scene, plan_.dt, physics_}, groups_, *rods_, kept, print_warning);
    if (found) {
        restore(interactions_, found->saved);
        if (settling_) settling_->restore(found->saved.back());
        clock_ = Clock(plan_.dt, found->step, plan_.integrator, found->shift);
        ancestry_ = found->ancestry;
        if (found->shift != 0) plan_.steps = std::max<std::int64_t>(1, clock_.step_at(scene.time.duration));
    }
    if (resumes) {
        last_checkpoint_ = found->step;
        checkpoint_digest_ = found->digest;
        if (comm_.root() && writes)
            std::printf("Resuming from %s: step %lld, %s%s\n", found->file.c_str(), static_cast<long long>(found->step),
                        share_done(found->step, plan_.steps).c_str(),
                        plan_.audit && !found->audited_from ? "; it has no audit, which begins here" : "");
    } else {
        on_root(comm_, [&] {
            if (writes) directory_->begin(with_ancestry(physics_, ancestry_));
            if (found)
                std::printf("Beginning with %s: step %lld, t = %g s\n", found->file.c_str(),
                            static_cast<long long>(found->step), clock_.time());
        });
        begins_branch_ = found.has_value();
    }
    first_step_ = clock_.done();
    if (plan_.audit) begin_audit(found ? found->audited_from : std::nullopt);
    last_step_ = plan_.steps;
    if (options_.until > 0) last_step_ = std::min<std::int64_t>(last_step_, clock_.step_at(options_.until));
    if (options_.steps > 0) last_step_ = std::min(last_step_, options_.steps);
    last_step_ = whole_event(last_step_, plan_.events_every());
    if (writes && first_step_ > 0 && plan_.rest_speed > 0 && first_step_ % plan_.cadence.series == 0) {
        take_sample();
        test_for_rest();
    }
    progress_columns_ = columns_of(scene.output.progress, names());
    const CheckpointInfo* const resumed = resumes ? &*found : nullptr;
    idle_ = writes && resumes && (first_step_ >= last_step_ || ended()) && has_record(found->digest);
    if (writes && !idle_) open_outputs(scene, resumed);
    progress_ = std::make_unique<Progress>(comm_.root() && (!options_.quiet || options_.place), options_.progress,
                                           first_step_, last_step_, plan_.dt, static_cast<double>(plan_.elements),
                                           scene.output.progress, options_.place);
}

Simulation::~Simulation() = default;

std::shared_ptr<Exposure> Simulation::make_bodies(std::span<const LocalRod> owned) {
    interactions_.clear();
    neighbourhood_.reset();
    const Surroundings around = make_rods_of(owned);
    if (around.exposure) neighbourhood_ = std::make_unique<Neighbourhood>(comm_, threads_, around.exposure);
    interactions_ = make_interactions({comm_, threads_, plan_, groups_, *rods_, around});
    return around.exposure;
}

Surroundings Simulation::make_rods_of(std::span<const LocalRod> owned) {
    rods_.reset();
    Surroundings around{.walls = walls_}; // their servos' state is recalled
    rods_ = make_rods(plan_, groups_, owned, threads_, around);
    walls_ = around.walls;
    if (settling_) settling_->watch(around.residual);
    return around;
}

void Simulation::move_bodies(const Step& step) {
    const double began = wall_seconds();
    const std::vector<Assignment> assigned = balance_.assign(groups_, *rods_, interactions_);
    const std::int64_t moving = Migration::count(comm_, assigned);
    if (moving > 0 || options_.balance == Balance::always) {
        const std::vector<SavedNumbers> kept = skein::saved(interactions_);
        const Migration migration(comm_, groups_, *rods_, assigned, kernels(plan_.machine.lanes).lanes,
                                  threads_.count());
        const Surroundings around = make_rods_of(migration.owned());
        migration.put_into(*rods_);
        rods_->begin_within(step);
        for (std::size_t i = 0; i < migration.owned().size(); ++i)
            around.exposure->show(i, migration.state(i), nth(groups_, migration.owned()[i].group).body());
        neighbourhood_->follow(around.exposure);
        for (const auto& interaction : interactions_)
            interaction->follow({comm_, threads_, plan_, groups_, *rods_, around});
        restore(interactions_, kept);
        ++owners_;
    }
    const double seconds = wall_seconds() - began;
    timers_.move(Phase::search, Phase::balance, seconds);
    balance_.moved(seconds, moving, step.index);
}

void Simulation::follow_owners() {
    if (outputs_owners_ == owners_) return;
    const auto timing = timers_.time(Phase::output);
    for (const auto& output : outputs_) output->follow(*rods_);
    outputs_owners_ = owners_;
}

bool Simulation::has_record(std::uint64_t digest) const {
    EarlierSummary earlier;
    on_root(comm_, [&] { earlier = read_summary(options_.out + "/summary.json", digest, output_); });
    if (earlier.ended && !options_.quiet) {
        std::printf("Nothing to do: the run has come to its end, and its files stay as they are\n");
        if (!earlier.changes.empty())
            std::printf("[output] has changed, which takes no effect on a run that is over:%s\n",
                        earlier.changes.c_str());
    }
    return comm_.max(static_cast<std::int64_t>(earlier.ended)) > 0;
}

void Simulation::begin_audit(std::optional<double> audited_from) {
    audited_from_ = audited_from;
    if (audited_from_) return;
    if (ContactInteraction* contacts = contacts_of(interactions_)) contacts->begin_audit(clock_.lag());
    audited_from_ = observed_energy(observe(comm_, threads_, groups_, *rods_, clock_.time(), clock_.lag()));
    for (std::size_t i = 0; i < rods_->local().size(); ++i)
        rods_->set_budget(i, {}); // a damaged checkpoint may have left its own
}

std::optional<double> Simulation::audited_from() const {
    const ContactInteraction* contacts = contacts_of(interactions_);
    return audited_from_ && contacts ? *audited_from_ + contacts->booked_at_start() : audited_from_;
}

std::uint64_t Simulation::digest() const { return comm_.sum_wrapping(rods_->digest() + digest_of(interactions_)); }

void Simulation::advance(std::int64_t until) {
    const bool coupled = is_coupled(plan_),
               together = coupled || settling_ || options_.protocol == Protocol::synchronous;
    bool going = true;
    while (clock_.done() < until && going) {
        const std::int64_t next_check = (clock_.done() / check_every + 1) * check_every;
        const auto steps = coupled || settling_
                               ? clock_.next(std::min({until, next_check, next_coupling(interactions_, clock_.done())}))
                               : clock_.next(until, together ? 1 : Clock::largest_batch);
        const std::int64_t last = steps.back().index;
        const bool check = last == until || last >= next_check;
        const bool valid = coupled ? step_coupled(steps, check) : step_uncoupled(steps, check);
        clock_.advance(steps);
        if (check && !warned_limit_ && near_limit_.empty()) {
            near_limit_ = rods_->near_limit();
            if (!near_limit_.empty()) near_limit_ += fmt::format(" at step {}", clock_.done());
        }
        if (check) undamped_share_ = std::max(undamped_share_, rods_->undamped_share());
        for (const auto& interaction : interactions_)
            if (check) interaction->watch(steps.back());
        if (!valid) failure_ = reason_of_failure(); // the other ranks learn of it when they meet
        if (settling_ && (clock_.done() % check_every == 0 || clock_.done() == plan_.steps)) measure_settling();
        going = (together ? all_ranks_valid() : failure_.empty()) && !ended();
    }
}

bool Simulation::step_uncoupled(std::span<const Step> steps, bool check) {
    const auto timing = timers_.time(Phase::rods);
    const bool valid = rods_->advance(steps, check); // per tile: drift, forces, loads, kick
    return valid && (!check || invalid(interactions_).empty());
}

bool Simulation::step_coupled(std::span<const Step> steps, bool check) {
    const auto timed = [&](Phase phase, auto&& work) {
        const auto timing = timers_.time(phase);
        work();
    };
    bool valid = true;
    for (const auto& interaction : interactions_) interaction->begin(steps.front(), timers_);
    const auto is_valid = [&] { return valid && (!check || invalid(interactions_).empty()); };
    if (!neighbourhood_ && !ends_every_step(interactions_)) { // rods by themselves, until the fluid meets them
        timed(Phase::rods, [&] { valid = rods_->advance(steps, check); });
        for (const auto& interaction : interactions_) interaction->end_step(steps.back(), timers_);
        return is_valid();
    }
    timed(Phase::rods, [&] { rods_->drift(steps.front()); }); // per tile: drift, expose
    for (std::size_t i = 0; i < steps.size(); ++i) {
        const auto at_rebuild = [&] {
            if (balance_.due()) move_bodies(steps[i]);
        };
        if (neighbourhood_)
            couple(interactions_, *neighbourhood_, steps[i], timers_, at_rebuild); // contacts; ghosts meanwhile
        timed(Phase::rods, [&] { // per tile: forces, loads, walls, kick; then the next drift
            if (i + 1 < steps.size()) rods_->kick_and_drift(steps[i], steps[i + 1]);
            else valid = rods_->kick(steps[i], check);
        });
        for (const auto& interaction : interactions_) interaction->end_step(steps[i], timers_); // servos
    }
    return is_valid();
}

std::string Simulation::reason_of_failure() const {
    try {
        rods_->inspect(clock_.done(), plan_.dt);
    } catch (const NumericalError& e) {
        return e.what();
    }
    const std::string reason = invalid(interactions_);
    return reason.empty() ? reason : fmt::format("{} at step {}", reason, clock_.done());
}

bool Simulation::ended() const { return at_rest_ || (settling_ && settling_->settled()) || finished(interactions_); }

void Simulation::measure_settling() {
    const auto timing = timers_.time(Phase::agree);
    settling_->measure(comm_);
}

void Simulation::test_for_rest() {
    at_rest_ = plan_.rest_speed > 0 && clock_.done() > 0 && last_sample_[observed_speed] < plan_.rest_speed;
}

bool Simulation::all_ranks_valid() {
    const auto timing = timers_.time(Phase::agree);
    return comm_.max(static_cast<std::int64_t>(!failure_.empty())) == 0;
}

RunResult Simulation::run() {
    if (idle_) return {exit_code(), clock_.done(), digest()};
    try {
        return step_to_the_end();
    } catch (const IoError& error) {
        throw IoError(error.what() + save_what_can_be_saved());
    }
}

RunResult Simulation::step_to_the_end() {
    if (begins_branch_) checkpoint(); // from here on the parent is not needed
    if (first_step_ == 0) write_due();
    else write_due_of_state(); // a branch begins with it, and an error may have kept it from being written
    Verdict verdict = Verdict::go_on;
    next_tick_ = clock_.done() + tick_multiple;
    setup_s_ = wall_seconds() - started_;
    while (clock_.done() < last_step_ && verdict == Verdict::go_on && !ended()) {
        keep_copy();
        advance(next_event());
        verdict = agree();
        follow_owners();
        write_due();
        show_progress(verdict != Verdict::go_on);
    }
    progress_->finish();
    warn_of_gain();
    checkpoint();
    write_end(false);

    const RunResult result{exit_code(), clock_.done(), sample_at_end()};
    write_summary(result);
    if (settling_ && comm_.root()) settling_->tell(clock_.done(), plan_.steps, options_.quiet);
    return result;
}

std::int64_t Simulation::next_event() const {
    std::int64_t next = std::min(last_step_, next_tick_);
    for (const auto& output : outputs_) next = std::min(next, output->next(clock_.done()));
    if (plan_.cadence.checkpoint > 0) next = std::min(next, multiple_after(clock_.done(), plan_.cadence.checkpoint));
    return whole_event(next, plan_.events_every());
}

Exit Simulation::exit_code() const {
    if (clock_.done() < last_step_ && !ended()) return Exit::limit;
    return settling_ && !settling_->settled() && clock_.done() >= plan_.steps ? Exit::unsettled : Exit::done;
}

Simulation::Verdict Simulation::agree() {
    const auto timing = timers_.time(Phase::agree);
    const double wall = wall_seconds() - started_;
    checkpoints_.update();
    const bool late = options_.walltime > 0 && checkpoints_.late(options_.walltime);
    const bool tells = (!near_limit_.empty() && !warned_limit_) || overlaps_untold(interactions_);
    const Verdict mine = !failure_.empty()          ? Verdict::fail
                         : stop_requested() || late ? Verdict::stop_at_limit
                         : tells                    ? Verdict::warn
                                                    : Verdict::go_on;
    auto verdict = static_cast<Verdict>(comm_.max(static_cast<std::int64_t>(mine)));
    if (verdict == Verdict::warn || verdict == Verdict::fail) {
        warn_of_limit();
        warn_of_overlap();
    }
    if (verdict == Verdict::fail) warn_of_gain();
    if (verdict == Verdict::fail) throw_failure();
    if (verdict == Verdict::warn) verdict = Verdict::go_on;
    if (clock_.done() >= next_tick_) {
        // As many steps as fit at the speed so far; root's figure for all.
        const double speed = static_cast<double>(clock_.done() - first_step_) / std::max(1e-9, wall - setup_s_);
        const double seconds =
            checkpoints_.every() > 0 ? std::min(tick_seconds, 0.5 * checkpoints_.every()) : tick_seconds;
        const auto visits = static_cast<std::int64_t>(std::min(1e9, speed * seconds / tick_multiple));
        next_tick_ = clock_.done() + tick_multiple * comm_.broadcast(std::max<std::int64_t>(1, visits));
        if (checkpoints_.every() > 0) save_now_ = comm_.broadcast(static_cast<std::int64_t>(checkpoints_.due())) != 0;
        if (plan_.cadence.frames_wall > 0)
            close_now_ = comm_.broadcast(static_cast<std::int64_t>(wall_seconds() - frames_closed_ >=
                                                                   plan_.cadence.frames_wall)) != 0;
        balance_.update(timers_, *rods_, interactions_, clock_.done(), last_step_ - clock_.done());
        if (!progress_columns_.empty())
            show_now_ = comm_.broadcast(static_cast<std::int64_t>(progress_->due(clock_.done()))) != 0;
    }
    return verdict;
}

std::string Simulation::contacts() const {
    const ContactInteraction* contacts = contacts_of(interactions_);
    std::string text;
    if (contacts)
        for (const std::string& part : comm_.all_gather(contacts->table())) text += part;
    return text;
}

bool Simulation::due(std::int64_t every) const { return every > 0 && clock_.done() % every == 0; }

void Simulation::show_progress(bool last) {
    std::vector<double> values;
    if (!progress_columns_.empty() && (show_now_ || last || clock_.done() >= last_step_ || ended())) {
        const auto timing = timers_.time(Phase::observe);
        take_sample();
        for (const std::size_t column : progress_columns_) values.push_back(last_sample_[column]);
    }
    show_now_ = false;
    progress_->show(clock_.done(), values,
                    settling_ ? fmt::format("  correction {:.3g}", settling_->correction()) : std::string());
}

std::vector<std::string> Simulation::names() const {
    if (groups_.empty()) return names_of_figures(interactions_);
    auto all = observable_names(sets_);
    if (plan_.audit) all.insert(all.end(), std::begin(audit_names), std::end(audit_names));
    for (std::string& name : names_of_figures(interactions_)) all.push_back(std::move(name));
    if (plan_.gravity) all.emplace_back("potential[J]");
    if (plan_.gravity && sets_.order) all.emplace_back("agitation[-]");
    return all;
}

std::vector<double> Simulation::observables() const {
    if (groups_.empty()) return values_of_figures(comm_, interactions_, clock_.lag());
    auto values = observe(comm_, threads_, groups_, *rods_, clock_.time(), clock_.lag(), sets_);
    if (plan_.audit) {
        EnergyAudit a = audit_scene(comm_, *rods_, observed_energy(values));
        if (const ContactInteraction* contacts = contacts_of(interactions_))
            a.contacts = contacts->booked(clock_.lag());
        values.insert(values.end(), {a.loads, a.walls, a.dissipated, a.defect(*audited_from())});
    }
    const Vec3d centre{values[observed_centre], values[observed_centre + 1], values[observed_centre + 2]};
    for (const double x : values_of_figures(comm_, interactions_, clock_.lag())) values.push_back(x);
    if (plan_.gravity) values.push_back(-plan_.mass * dot(*plan_.gravity, centre));
    if (plan_.gravity && sets_.order)
        values.push_back(values[observed_translation] / (norm(*plan_.gravity) * plan_.mass_radius));
    return values;
}

void Simulation::take_sample() {
    if (sampled_ == clock_.done()) return;
    last_sample_ = observables();
    sampled_ = clock_.done();
}

std::uint64_t Simulation::sample_at_end() {
    const auto timing = timers_.time(Phase::observe);
    take_sample();
    return last_checkpoint_ == clock_.done() ? checkpoint_digest_ : digest();
}

void Simulation::sample() {
    const auto timing = timers_.time(Phase::observe);
    take_sample();
    warn_of_strain();
    test_for_rest();
}

void Simulation::checkpoint() {
    if (last_checkpoint_ == clock_.done()) return;
    close_files();
    keep_state();
}

void Simulation::keep_state() {
    if (!options_.checkpoint) return;
    const auto timing = timers_.time(Phase::checkpoint);
    checkpoints_.begin_saving();
    saving_ = true; // an error from here on is that of a checkpoint
    checkpoint_digest_ = digest();
    CheckpointInfo info{clock_.done(), plan_.dt, checkpoint_digest_, physics_, {}, audited_from()};
    info.shift = clock_.shift();
    info.settings = settings_;
    info.ancestry = ancestry_;
    info.beyond = comm_.sum_wrapping(digest_of(interactions_));
    info.saved = saved(interactions_);
    if (settling_) info.saved.push_back(settling_->saved());
    for (const auto& output : outputs_) output->mark(info);
    write_checkpoint(comm_, options_.out, groups_, *rods_, info, plan_.keeping);
    last_checkpoint_ = clock_.done();
    saving_ = false;
    checkpoints_.end_saving();
}

void Simulation::write_summary(const RunResult& result) {
    RunFigures figures{.plan = plan_,
                       .result = result,
                       .finished = result.step == plan_.steps || ended(),
                       .first_step = first_step_,
                       .time_s = clock_.time(),
                       .ancestry = ancestry_,
                       .protocol = is_coupled(plan_) ? Protocol::synchronous : options_.protocol,
                       .wall_s = wall_seconds() - started_,
                       .names = names(),
                       .observables = last_sample_,
                       .output = output_};
    figures.settling = settling_ ? &*settling_ : nullptr;
    for (std::size_t p = 0; p < phase_count; ++p) {
        const double mine = timers_.seconds(static_cast<Phase>(p));
        figures.phases.push_back({comm_.min(mine),
                                  static_cast<double>(comm_.sum(std::llround(mine * 1e6))) * 1e-6 / comm_.size(),
                                  comm_.max(mine)});
    }
    figures.rod_bytes = comm_.sum(static_cast<std::int64_t>(rods_->bytes()));
    figures.resident_bytes = comm_.sum(resident_bytes());
    figures.overlaps = largest_overlaps(comm_, interactions_);
    if (const FluidInteraction* fluid = fluid_of(interactions_)) {
        figures.cell_steps = fluid->cell_steps();
        figures.speed_to_expect = fluid->speed_to_expect();
        figures.slips = fluid->slips();
        figures.slip_warning = fluid->warning();
    }
    if (neighbourhood_ && comm_.size() > 1) {
        figures.ghosts = neighbourhood_->figures_of_ranks();
        figures.balance = balance_.figures();
    }
    on_root(comm_, [&] {
        write_file(options_.out + "/summary.json", summary_json(figures));
        if (!options_.quiet) std::printf("%s", timing_table(figures).c_str());
        if (!figures.slip_warning.empty()) print_warning(figures.slip_warning);
    });
}

} // namespace skein
