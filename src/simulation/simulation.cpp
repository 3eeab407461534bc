#include "simulation/simulation.hpp"

#include "core/stop.hpp"
#include "io/disk.hpp"
#include "io/end_record.hpp"
#include "physics/audit/audit_plan.hpp"
#include "physics/contact/contact_interaction.hpp"
#include "physics/loads/load_plan.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_rebuild.hpp"
#include "simulation/branch.hpp"
#include "simulation/start.hpp"
#include "simulation/summary.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <span>

namespace skein {

namespace {

constexpr double tick_seconds = 1; ///< wall time between two agreements of all ranks
constexpr Every ticks{64};         ///< steps between them at least: fewer would cut batches short

/// The groups, whose rods of files have values at the start that loads accept. Collective.
std::vector<RodGroup> checked(const Communicator& comm, const Plan& plan, std::vector<RodGroup> groups) {
    if (has_rods_of_files(groups))
        if (const std::string fault = comm.first_text(fault_of_read_rods(plan, groups)); !fault.empty())
            throw InputError(fault);
    return groups;
}

/// `numbers`: the scene with numbers in place of "auto"; `groups`: with all of their rods.
SceneTexts texts_of(const SceneSpec& scene, const SceneSpec& numbers, std::span<const RodGroup> groups, double dt) {
    return {physics_json(numbers, groups, dt), settings_json(scene), output_json(scene), {}};
}

/// Columns are found by their names without units.
void refuse_repeated_columns(std::span<const std::string> names) {
    std::set<std::string> seen;
    for (const std::string& column : names)
        if (const std::string name = column.substr(0, column.find('[')); !seen.insert(name).second)
            throw InputError(
                fmt::format("the time series has two columns '{}': give the [[probe]], "
                            "[[fluid_probe]], [[joint]], [[wall]], [[obstacle]] or group of one another 'name'",
                            name));
}

} // namespace

Simulation::Simulation(const Communicator& comm, const Threads& threads, const SceneSpec& scene,
                       std::vector<RodGroup> groups, Plan plan, RunOptions options)
    : options_(std::move(options)), started_(options_.began > 0 ? options_.began : wall_seconds()),
      stages_(scene, groups), texts_(texts_of(scene, stages_.scene(), groups, plan.dt)),
      world_(comm, threads, checked(comm, plan, std::move(groups)), plan, options_.protocol, options_.balance),
      observation_(world_, scene), warnings_(world_, options_.quiet), rewind_(world_, options_.rewind, options_.out) {
    const bool writes = !options_.out.empty();
    Plan& made = world_.plan;
    const std::vector<std::string> columns = observation_.names();
    refuse_repeated_columns(columns);
    stages_.find_columns(columns);
    for (const ExpectSpec& expected : scene.expected)
        columns_of("expect.column", std::vector{expected.column}, columns);
    refuse_bad_start(world_, scene, options_);
    on_root(comm, [&] {
        if (writes) directory_ = std::make_unique<ResultsDirectory>(options_.out, options_.overwrite);
    });
    const Start start = start_of(world_, stages_, scene, texts_.physics, options_);
    const std::optional<CheckpointInfo>& found = start.found;
    if (found) texts_.ancestry = found->ancestry;
    begins_branch_ = found && !start.resumes;
    if (start.resumes && comm.root() && writes)
        std::printf("Resuming from %s: step %lld, %s%s\n", found->file.c_str(), static_cast<long long>(found->step),
                    share_done(found->step, made.steps).c_str(),
                    made.has<AuditPlan>() && !found->audited_from ? "; it has no audit, which begins here" : "");
    if (!start.resumes)
        on_root(comm, [&] {
            if (writes) directory_->begin(with_ancestry(texts_.physics, texts_.ancestry));
            if (found)
                std::printf("Beginning with %s: step %lld, t = %g s\n", found->file.c_str(),
                            static_cast<long long>(found->step), world_.clock.time());
        });
    if (stages_.any() && !found) stages_.go_on(stages_.begins(), world_);
    if (made.has<AuditPlan>()) observation_.begin_audit(world_, found ? found->audited_from : std::nullopt);
    if (found) observation_.set_stage_work(found->stage_work);
    if (found && found->stage_over) {
        stages_.set_over("as was found before");
        observation_.set_left(found->stage_defect, found->stage_contacts);
    }
    first_step_ = world_.clock.done();
    last_step_ = made.steps;
    if (options_.until > 0) last_step_ = std::min<std::int64_t>(last_step_, world_.clock.step_at(options_.until));
    if (options_.steps > 0) last_step_ = std::min(last_step_, options_.steps);
    last_step_ = Every{made.events_every}.from(last_step_);
    if (writes && first_step_ > 0) test_for_rest();
    if (first_step_ > 0 && stages_.is_last()) begin_due_stage(); // which may end the run
    const std::vector<std::size_t> progress_columns =
        columns_of("output.progress", scene.output.progress, observation_.names());
    idle_ = writes && start.resumes && over() && has_record(found->digest);
    if (writes && !idle_) {
        on_root(comm, [&] { take_back_end(options_.out); });
        make_outputs({scene, world_, stages_, observation_, warnings_, outputs_, texts_, options_, started_, last_step_,
                      progress_columns, start.resumes ? &*found : nullptr});
        for (const auto& output : outputs_)
            if (auto* one = dynamic_cast<CheckpointOutput*>(output.get())) checkpoints_ = one;
    }
    world_.timers.add(Phase::setup, wall_seconds() - started_);
}

Simulation::~Simulation() = default;

bool Simulation::has_record(std::uint64_t digest) const {
    EarlierSummary earlier;
    on_root(world_.comm, [&] { earlier = read_summary(options_.out + "/summary.json", digest, texts_.output); });
    if (earlier.ended && !options_.quiet) {
        std::printf("Nothing to do: the run has come to its end, and its files stay as they are\n");
        if (!earlier.changes.empty())
            std::printf("[output] has changed, which takes no effect on a run that is over:%s\n",
                        earlier.changes.c_str());
    }
    return world_.comm.max(static_cast<std::int64_t>(earlier.ended)) > 0;
}

RunResult Simulation::run() {
    if (idle_) return {exit_code(), world_.clock.done(), world_.digest()};
    try {
        return step_to_the_end();
    } catch (const IoError& error) {
        throw IoError(error.what() + checkpoints_->rescue(now()));
    }
}

RunResult Simulation::step_to_the_end() {
    if (begins_branch_) write(*checkpoints_); // from here on the parent is not needed
    for (const auto& output : outputs_)       // an error may have kept a resumed state from being written
        if ((first_step_ == 0 || output->needs_state_alone()) && output->due(now())) write(*output);
    Verdict verdict = Verdict::go_on;
    next_tick_ = world_.clock.done() + ticks.steps;
    setup_s_ = wall_seconds() - started_;
    while (!over() && verdict == Verdict::go_on) {
        begin_due_stage(); // not where the run ends: its last checkpoint says that the stage is over
        if (over()) break;
        rewind_.keep_copy();
        world_.advance(next_event());
        verdict = agree();
        stages_.look(world_, observation_);
        write_due();
    }
    warnings_.end_line();
    warnings_.warn_of_gain();
    write(*checkpoints_);
    write_end(false);

    const RunResult result{exit_code(), world_.clock.done(), digest_at_end()};
    write_summary(result);
    return result;
}

RunResult Simulation::go_to_end(const std::function<void(World&)>& change) {
    return go_by(last_step_, [&](World& world) {
        change(world);
        return true;
    });
}

RunResult Simulation::go_through(const std::function<bool(World&)>& change) { return go_by(1, change); }

RunResult Simulation::go_by(std::int64_t steps, const std::function<bool(World&)>& change) {
    if (!checkpoints_)
        throw InputError(
            fmt::format("'{}' holds a run that is over: a solution needs a directory of its own", options_.out));
    if (first_step_ == 0) world_.evaluate_at_rest(world_.clock.time());
    for (const auto& output : outputs_)
        if (first_step_ == 0 && output->due(now())) write(*output);
    setup_s_ = wall_seconds() - started_;
    const Rods* rods = &world_.rods();
    bool stopped = false;
    while (!stopped && world_.clock.done() < last_step_ && change(world_)) {
        if (rods != &world_.rods()) // others took their places, with other numbers of the scene
            for (const auto& output : outputs_) output->rebind(world_.rods());
        rods = &world_.rods();
        const std::int64_t step = std::min(last_step_, world_.clock.done() + steps);
        world_.clock = Clock(world_.plan.dt, step, world_.plan.integrator, world_.clock.shift());
        for (const auto& output : outputs_)
            if (output->due(now())) write(*output);
        stopped = step < last_step_ && world_.comm.max(static_cast<std::int64_t>(stop_requested())) > 0;
    }
    if (!stopped) world_.plan.steps = world_.clock.done(); // a path that ends early is whole
    write(*checkpoints_);
    write_end(false);
    const RunResult result{stopped ? Exit::limit : Exit::done, world_.clock.done(), digest_at_end()};
    write_summary(result);
    return result;
}

std::uint64_t Simulation::digest_at_end() {
    const auto timing = world_.timers.time(Phase::observe);
    observation_.sample();
    return checkpoints_->last() == world_.clock.done() ? checkpoints_->last_digest() : world_.digest();
}

void Simulation::write(Output& output) {
    const auto timing = world_.timers.time(output.phase());
    output.write(now());
}

void Simulation::advance(std::int64_t until) {
    begin_due_stage();
    while (world_.clock.done() < until && world_.failure().empty() && !ended()) {
        world_.advance(std::min(until, stages_.next(world_.clock.done())));
        stages_.look(world_, observation_);
        if (world_.clock.done() < until) begin_due_stage();
    }
}

void Simulation::begin_due_stage() {
    const std::string reason = stages_.over();
    if (reason.empty() || stages_over_) return;
    const std::string ended = stages_.spec().name;
    const auto tell = [&](const std::string& next) {
        if (!world_.comm.root() || options_.quiet || options_.out.empty()) return;
        warnings_.end_line();
        std::printf("Step %lld, t = %g s: stage '%s' ends (%s)%s\n", static_cast<long long>(world_.clock.done()),
                    world_.clock.time(), ended.c_str(), reason.c_str(), next.c_str());
    };
    stages_over_ = stages_.is_last();
    if (stages_over_) return tell("; it was the last");
    try {
        next_stage();
    } catch (const InputError& error) { // another scene may go on from where it is
        if (!checkpoints_ || !options_.checkpoint) throw;
        write(*checkpoints_);
        throw InputError(fmt::format(
            "{}\n  the state at its begin is kept in the checkpoint of step {}, from which a branch may continue",
            error.what(), world_.clock.done()));
    }
    tell(fmt::format("; stage '{}' begins", stages_.spec().name));
}

void Simulation::next_stage() {
    if (!stages_.any() || stages_.is_last())
        throw InputError(stages_.any() ? fmt::format("stage '{}' is the last", stages_.spec().name)
                                       : std::string("the scene has no [[stage]]"));
    observation_.leave_stage();
    stages_.begin_next(world_);
    observation_.enter_stage(world_);
    rewind_.forget();
    for (const auto& output : outputs_) output->rebind(world_.rods());
    outputs_owners_ = world_.owners();
}

std::int64_t Simulation::next_event() const {
    std::int64_t next = std::min({last_step_, next_tick_, stages_.next(world_.clock.done())});
    for (const auto& output : outputs_) next = std::min(next, output->next(world_.clock.done()));
    return Every{world_.plan.events_every}.from(next);
}

Exit Simulation::exit_code() const {
    if (!over()) return Exit::limit;
    const bool all_steps = world_.clock.done() >= world_.plan.steps;
    return all_steps && !fulfilled(world_.interactions()) ? Exit::unsettled : Exit::done;
}

Simulation::Verdict Simulation::agree() {
    const auto timing = world_.timers.time(Phase::agree);
    const bool late = checkpoints_->late();
    const Verdict mine = !world_.failure().empty()  ? Verdict::fail
                         : stop_requested() || late ? Verdict::stop_at_limit
                         : warnings_.due()          ? Verdict::warn
                                                    : Verdict::go_on;
    const auto verdict = static_cast<Verdict>(world_.comm.max(static_cast<std::int64_t>(mine)));
    if (verdict == Verdict::warn || verdict == Verdict::fail) warnings_.warn_of_limits();
    if (verdict == Verdict::fail) {
        warnings_.warn_of_gain();
        throw_failure();
    }
    if (world_.clock.done() >= next_tick_) tick();
    return verdict == Verdict::warn ? Verdict::go_on : verdict;
}

/// The next tick is as many steps away as fit at the speed so far; root's figure for all.
void Simulation::tick() {
    const std::int64_t done = world_.clock.done();
    const double stepping = wall_seconds() - started_ - setup_s_,
                 speed = static_cast<double>(done - first_step_) / std::max(1e-9, stepping);
    const double every = checkpoints_->every_wall();
    const double seconds = every > 0 ? std::min(tick_seconds, 0.5 * every) : tick_seconds;
    const auto batches = static_cast<std::int64_t>(std::min(1e9, speed * seconds / static_cast<double>(ticks.steps)));
    next_tick_ = done + ticks.steps * world_.comm.broadcast(std::max<std::int64_t>(1, batches));
    world_.balance().update(world_.timers, world_.rods(), world_.interactions(), done, last_step_ - done);
    for (const auto& output : outputs_) output->tick();
}

void Simulation::throw_failure() {
    warnings_.end_line();
    try { // frames and rows before the failure are good
        checkpoints_->flush_others();
        for (const auto& output : outputs_) output->finish();
    } catch (const IoError&) { // the run ends with the failure
    }
    const std::string reason = failure();
    if (const std::string text = advice(world_.interactions()); !text.empty())
        throw NumericalError(reason + "\n  " + text);
    const std::int64_t last = checkpoints_->last();
    if (world_.groups.empty())
        throw NumericalError(
            reason + (last >= 0 ? fmt::format("\n  the last good checkpoint is of step {}", last) : std::string()));
    const Failure found = rewind_.find([this] {
        for (const auto& output : outputs_) output->rebind(world_.rods());
        write_end(true);
    });
    throw NumericalError(text_of(found, world_.plan, last, options_.out));
}

void Simulation::write_due() {
    if (outputs_owners_ != world_.owners())
        for (const auto& output : outputs_) output->rebind(world_.rods());
    outputs_owners_ = world_.owners();
    for (const auto& output : outputs_)
        if (output->due(now())) write(*output);
    test_for_rest();
}

void Simulation::test_for_rest() {
    if (world_.plan.rest_speed == 0 || (stages_.any() && !stages_.is_last()) ||
        !Every{world_.plan.cadence.of("series")}.due(world_.clock.done()))
        return;
    observation_.sample();
    at_rest_ = observation_.speed() < world_.plan.rest_speed;
}

void Simulation::write_end(bool failed) {
    const auto timing = world_.timers.time(Phase::output);
    const auto shows = [failed](const Output& output) { return !failed || output.shows_failure(); };
    EndRecord record{world_.clock.done(), {}};
    for (const auto& output : outputs_)
        if (shows(*output))
            for (std::string& name : output->files_of_end(record.step)) record.files.push_back(std::move(name));
    if (!record.files.empty()) {
        checkpoints_->flush_others(); // records that are taken back later are in files of their own
        on_root(world_.comm, [&] { write_end_record(options_.out, record); });
        for (const auto& output : outputs_)
            if (shows(*output)) output->write_end(now());
        checkpoints_->flush_others();
    }
    for (const auto& output : outputs_) output->finish();
}

std::string Simulation::contacts() const {
    const ContactInteraction* contacts = contacts_of(world_.interactions());
    std::string text;
    if (contacts)
        for (const std::string& part : world_.comm.all_gather(contacts->table())) text += part;
    return text;
}

void Simulation::write_summary(const RunResult& result) {
    const Communicator& comm = world_.comm;
    const bool finished = result.step == world_.plan.steps || ended();
    const RunFigures figures = figures_of(
        world_, result,
        {finished, first_step_, wall_seconds() - started_, observation_.names(), observation_.sample(), texts_});
    on_root(comm, [&] {
        write_file(options_.out + "/summary.json", summary_json(figures));
        if (!options_.quiet) std::printf("%s", timing_table(figures).c_str());
        if (!figures.slip_warning.empty()) print_warning(figures.slip_warning);
        for (const auto& interaction : world_.interactions()) {
            if (!options_.quiet) std::printf("%s", interaction->report().c_str());
            if (const std::string text = interaction->final_warning(); !text.empty())
                std::fprintf(stderr, "%s\n", text.c_str());
        }
    });
}

} // namespace skein
