// A run: owns rods, clock and outputs, and carries out the plan. The step is Simulation::step_coupled, of uncoupled
// rods a visit.
#pragma once

#include "core/timer.hpp"
#include "diagnostics/extra_observables.hpp"
#include "io/checkpoint.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "scene/plan.hpp"
#include "simulation/checkpoint_clock.hpp"
#include "simulation/contact_interaction.hpp"
#include "simulation/fluid_interaction.hpp"
#include "simulation/load_balance.hpp"
#include "simulation/outputs.hpp"
#include "simulation/progress.hpp"
#include "simulation/results_directory.hpp"
#include "simulation/settling.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "skein/time/clock.hpp"
#include "tiles/rods.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

class StateCopy;

/// "warning: ...", on the stderr of this process.
void print_warning(const std::string& text);

/// How steps, threads and ranks meet; the bits are the same.
enum class Protocol {
    asynchronous, ///< a tile takes many steps per visit, ranks meet at events: where no rod feels another
    synchronous ///< one step per visit, all threads and ranks meet after it: what rods that feel each other would force
};
inline constexpr std::string_view protocol_names[] = {"asynchronous", "synchronous"};

/// Whether a copy of the state is kept in memory, to find out where a failure began.
enum class Rewind {
    automatic, ///< where it takes less than 1 GiB of a rank
    always,
    never
};

struct RunOptions {
    std::string out;        ///< directory of results
    bool overwrite = false; ///< put earlier results into a folder of their own and start anew
    std::int64_t steps = 0; ///< stop after this step; 0: the scene's end
    double until = 0;       ///< stop at this time, s; 0: the scene's end
    double walltime = 0;    ///< end with a checkpoint within this many seconds; 0: never
    double began = 0;       ///< wall_seconds() from which these count; 0: the simulation's construction
    Protocol protocol = Protocol::asynchronous;
    bool checkpoint = true; ///< false: none is written, not even at the end; for timing
    bool quiet = false;     ///< no progress line
    ProgressStyle progress = ProgressStyle::automatic;
    std::optional<PlaceAmongRuns> place =
        {}; ///< of one of several runs, which have a progress line even where they are quiet
    Rewind rewind = Rewind::automatic;
    Balance balance = Balance::automatic;
    std::string from =
        {}; ///< with no `out`, where nothing is written: begin with this checkpoint; empty: with the scene
};

/// How a run ended.
struct RunResult {
    Exit code = Exit::done;
    std::int64_t step = 0;
    std::uint64_t digest = 0;
};

class Simulation {
public:
    /// Collective. Partitions the rods, takes the newest checkpoint in options.out, opens outputs. Throws before
    /// anything is overwritten where the directory holds something else.
    Simulation(const Communicator& comm, const Threads& threads, const SceneSpec& scene, std::vector<RodGroup> groups,
               Plan plan, RunOptions options);
    ~Simulation();

    /// Steps to the end (or a limit of the options), with outputs; writes checkpoint and summary. Throws NumericalError
    /// or IoError on all ranks alike.
    RunResult run();
    /// Whether the run was at its end before it began: run() then does and writes nothing.
    bool idle() const { return idle_; }

    const Plan& plan() const { return plan_; }
    const RodGroup& group(int number) const { return nth(groups_, number); }
    const Rods& rods() const { return *rods_; }
    std::int64_t step() const { return clock_.done(); }
    double time() const { return clock_.time(); }
    double lag() const { return clock_.lag(); }
    std::uint64_t digest() const; ///< of the whole scene; collective
    /// Names and values of the series; the values are collective.
    std::vector<std::string> names() const;
    std::vector<double> observables() const;
    /// Table of all contacts; empty where rods do not feel each other. Collective.
    std::string contacts() const;
    /// Reason why rods of some rank became invalid since the start; empty: nothing. Collective.
    std::string failure() const { return comm_.first_text(failure_); }

    /// Steps up to `until` without looking at outputs: what a run does between two events.
    void advance(std::int64_t until);

    /// How the present state differs from that of a checkpoint of the same step, which is loaded; empty where it does
    /// not. Collective.
    std::string difference_to(const std::string& checkpoint);

private:
    /// Steps of rods without coupling, many in a visit. With `check`, false where a rod is invalid.
    bool step_uncoupled(std::span<const Step> steps, bool check);
    /// Steps of rods with coupling, which wait for each other in each. With `check` as before.
    bool step_coupled(std::span<const Step> steps, bool check);
    /// Why rods or interactions of this rank cannot go on; empty where they can.
    std::string reason_of_failure() const;
    /// Rods in their start state, and what they do to each other. Collective.
    /// Returns what they show each other, nothing yet; null where they do not.
    std::shared_ptr<Exposure> make_bodies(std::span<const LocalRod> owned);
    /// Rods in their start state and what surrounds them, in place of those that there are.
    Surroundings make_rods_of(std::span<const LocalRod> owned);
    /// Bodies go to the ranks that are to own them, within a step. Collective.
    void move_bodies(const Step& step);
    /// Outputs learn of new owners. Collective.
    void follow_owners();
    enum class Verdict { go_on, warn, stop_at_limit, fail };

    /// `resumed`: the checkpoint of this directory that the run goes on from; null: none, and of a branch that begins.
    void open_outputs(const SceneSpec& scene, const CheckpointInfo* resumed);
    RunResult step_to_the_end();
    std::unique_ptr<Output> polydata(const SceneSpec& scene, const CheckpointInfo* resumed);
    bool due(std::int64_t every) const;
    Moment now() const;
    void write_due_of_state();
    /// Writes of the last step, or of that at which a failure began, what no interval has asked for, and closes all
    /// files.
    void write_end(bool failed);
    void finish_files();
    /// `last`: no other will follow.
    void show_progress(bool last);
    /// Whether summary.json tells of the end of this very state; then also tells what has changed in [output] since.
    /// Collective.
    bool has_record(std::uint64_t digest) const;
    /// After an I/O error: frames that are whole and the state. Returns what to tell of it. Collective.
    std::string save_what_can_be_saved();
    void keep_state(); ///< the part of checkpoint() that writes it
    /// Goes on with the audit of a checkpoint, or begins one here. Collective.
    void begin_audit(std::optional<double> audited_from);
    /// The energy that the audit began with, J, with that of contacts. Collective.
    std::optional<double> audited_from() const;
    void write_due();
    void checkpoint();
    /// So that others can read what the run has written so far.
    void close_files();
    void sample();
    /// The row of this step; none where an energy is not a number. Collective.
    std::optional<std::span<const double>> row();
    /// Observables of this step, once. Collective.
    void take_sample();
    /// The last sample, and the digest of the whole scene. Collective.
    std::uint64_t sample_at_end();
    /// Tells once of strains and turns that the last sample shows to be near what the rod law or the discretisation
    /// bears.
    void warn_of_strain();
    /// The same of a step near the limit that strains leave; collective.
    void warn_of_limit();
    /// At the end, of rods without damping that strain fed; collective.
    void warn_of_gain();
    void warn(bool& told, bool bad, const std::string& text);
    std::int64_t next_event() const;
    /// The same of overlaps beyond what the step allows for; collective.
    void warn_of_overlap();
    /// All ranks learn of failures, signals, limits and what to be warned of; sets the next tick. Throws NumericalError
    /// where a rank failed.
    Verdict agree();
    /// By what happens in the scene, before its duration is over.
    bool ended() const;
    void test_for_rest();
    Exit exit_code() const;
    /// At steps that are alike on any ranks: whether rods that relax have settled. Collective.
    void measure_settling();
    /// Where ranks meet after every step: false on all of them as soon as one has failed.
    bool all_ranks_valid();
    /// At an event, if it is time for one.
    void keep_copy();
    void go_back(const StateCopy& copy);
    /// Steps that were made before; with `look`, false on all ranks where a rod of some rank is invalid after the last.
    bool redo(std::int64_t until, bool look);
    struct InvalidRod;
    InvalidRod first_invalid_rod() const;
    double present_limit() const; ///< of the step, s, as rods are now
    enum class Remedy { unknown, step, untried, none };
    struct Failure {
        std::string text;
        std::string cause = {};    ///< as far as interactions know it; empty: they do not
        std::string settings = {}; ///< KEY=VALUE that would do, joined by --set
        std::string frame = {};    ///< where all rods at that step are to be seen
        std::int64_t step = -1;    ///< -1: not found
        double dt = 0;             ///< s, the last that was tried; 0: none was
        Remedy remedy = Remedy::unknown;
    };
    /// Where a failure of some rank began. Collective.
    Failure find_failure();
    /// Makes rods anew, with the state that they had at a copy, for another step.
    void begin_again(const StateCopy& start, const Clock& was);
    /// From a copy to a time beyond the failure with a step of `dt`, and ever shorter ones until one holds. The run is
    /// over after it.
    void try_shorter_steps(Failure& failure, const StateCopy& start, double until, double dt);
    [[noreturn]] void throw_failure();
    void write_summary(const RunResult& result);

    const Communicator comm_;
    const Threads& threads_;
    std::vector<RodGroup> groups_;
    Plan plan_;
    RunOptions options_;
    ObservableSets sets_;
    std::optional<double> audited_from_; ///< J, energy that the audit began with
    std::string physics_;                ///< canonical scene, kept in checkpoints
    std::string settings_;               ///< the rest of it
    std::string output_;                 ///< its [output], kept in the summary
    std::string ancestry_;               ///< of a branch, JSON
    bool begins_branch_ = false;
    Timers timers_;
    double started_, setup_s_ = 0;
    CheckpointClock checkpoints_;
    bool save_now_ = false, close_now_ = false, saving_ = false, idle_ = false;
    double frames_closed_ = 0;                    ///< wall time
    std::unique_ptr<ResultsDirectory> directory_; ///< root only; null where nothing is written
    std::unique_ptr<Rods> rods_;
    std::shared_ptr<Walls> walls_;                 ///< null where there are none
    std::unique_ptr<Neighbourhood> neighbourhood_; ///< null where bodies do not feel each other
    Interactions interactions_;
    LoadBalance balance_;
    std::int64_t owners_ = 0,
                 outputs_owners_ = 0; ///< number of the distribution of rods over ranks; that which outputs know
    Clock clock_;
    std::int64_t first_step_ = 0, last_step_ = 0; ///< of this run
    std::int64_t next_tick_ = 0;                  ///< step at which ranks agree next
    std::int64_t last_checkpoint_ = -1;
    std::unique_ptr<StateCopy> copy_, first_copy_; ///< the latter of short runs
    bool was_copied_ = false;
    std::string failure_, near_limit_; ///< of this rank's rods; agreed on at the next event
    Outputs outputs_;                  ///< in the order in which they are written
    std::vector<double> last_sample_;
    std::int64_t sampled_ = -1;           ///< step of it
    std::uint64_t checkpoint_digest_ = 0; ///< at last_checkpoint_
    bool at_rest_ = false;
    std::optional<Settling> settling_; ///< of rods that relax
    bool warned_row_ = false, warned_turn_ = false, warned_strain_ = false, warned_tension_ = false,
         warned_limit_ = false;
    std::unique_ptr<Progress> progress_;
    std::vector<std::size_t> progress_columns_; ///< of the series
    bool show_now_ = false;
    double undamped_share_ = 0; ///< of this rank's rods without damping: how far the step was on the way to its limit
};

} // namespace skein
