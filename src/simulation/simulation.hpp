// A run: steps its world from event to event, and has its outputs write what is due. The step is World::step.
#pragma once

#include "core/timer.hpp"
#include "simulation/checkpoint_output.hpp"
#include "simulation/load_balance.hpp"
#include "simulation/observation.hpp"
#include "simulation/output.hpp"
#include "simulation/progress.hpp"
#include "simulation/results_directory.hpp"
#include "simulation/rewind.hpp"
#include "simulation/stages.hpp"
#include "simulation/warnings.hpp"
#include "simulation/world.hpp"
#include "skein/core/error.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace skein {

/// End of a run.
struct RunResult {
    Exit code = Exit::done;
    std::int64_t step = 0;
    std::uint64_t digest = 0;
};

class Simulation {
public:
    /// Partitions the rods, takes the newest checkpoint in options.out, opens outputs. Throws before anything is
    /// overwritten where the directory holds something else. Collective.
    Simulation(const Communicator& comm, const Threads& threads, const SceneSpec& scene, std::vector<RodGroup> groups,
               Plan plan, RunOptions options);
    ~Simulation();

    /// Steps to the end (or a limit of the options), with outputs; writes checkpoint and summary. Throws NumericalError
    /// or IoError on all ranks alike.
    RunResult run();
    /// Goes to the end of the scene with bodies that `change` has put elsewhere, in place of steps; writes the start,
    /// the end, a checkpoint and the summary. Collective.
    RunResult go_to_end(const std::function<void(World&)>& change);
    /// The same step by step, until `change` returns false or the scene is at its end. Collective.
    RunResult go_through(const std::function<bool(World&)>& change);
    /// True if the run was at its end before it began: run() then does and writes nothing.
    bool idle() const { return idle_; }

    const World& world() const { return world_; }
    World& world() { return world_; }
    const SceneTexts& texts() const { return texts_; }
    const Plan& plan() const { return world_.plan; }
    const Observation& observation() const { return observation_; }
    /// Table of all contacts; empty where rods do not interact. Collective.
    std::string contacts() const;
    /// Reason why rods of some rank became invalid since the start; empty: nothing. Collective.
    std::string failure() const { return world_.comm.first_text(world_.failure()); }

    /// Steps up to `until` without outputs.
    void advance(std::int64_t until);
    /// Begins the next stage at the present step. Throws InputError where there is none. Collective.
    void next_stage();
    /// True where no more steps are made: the scene has come to its end.
    bool finished() const {
        return world_.clock.done() >= world_.plan.steps || ended() || (stages_.is_last() && !stages_.over().empty());
    }
    const Stages& stages() const { return stages_; }

private:
    enum class Verdict { go_on, warn, stop_at_limit, fail };

    RunResult step_to_the_end();
    RunResult go_by(std::int64_t steps, const std::function<bool(World&)>& change);
    /// True until the run's last step, or until the scene itself has come to its end.
    bool over() const { return world_.clock.done() >= last_step_ || ended(); }
    bool ended() const {
        const bool next_stage_follows = !stages_.over().empty() && !stages_.is_last();
        return at_rest_ || stages_over_ || (world_.ended() && !next_stage_follows);
    }
    /// Begins the next stage where the present one ends with this step. Collective.
    void begin_due_stage();
    std::int64_t next_event() const;
    /// All ranks learn of failures, signals, limits and warnings; sets the next tick. Throws NumericalError where a
    /// rank failed.
    Verdict agree();
    void tick();
    [[noreturn]] void throw_failure();
    Moment now() const { return {world_.clock.done(), world_.clock.time(), world_.clock.lag()}; }
    /// Writes and counts the time as that of its phase.
    void write(Output& output);
    void write_due();
    std::uint64_t digest_at_end();
    /// Writes the part of the last step, or of that at which a failure began, that no interval has asked for, and
    /// closes all files.
    void write_end(bool failed);
    void test_for_rest();
    /// True if summary.json holds the end of this very state; then also prints changes of [output]. Collective.
    bool has_record(std::uint64_t digest) const;
    Exit exit_code() const;
    void write_summary(const RunResult& result);

    RunOptions options_;
    double started_, setup_s_ = 0;
    Stages stages_;    ///< with numbers from all rods: the world keeps those of this rank
    SceneTexts texts_; ///< of all rods too
    World world_;
    Observation observation_;
    Warnings warnings_;
    Rewind rewind_;
    std::unique_ptr<ResultsDirectory> directory_; ///< root only; null where nothing is written
    Outputs outputs_;                             ///< in the order in which they are written
    CheckpointOutput* checkpoints_ = nullptr;     ///< one of them
    std::int64_t first_step_ = 0, last_step_ = 0; ///< of this run
    std::int64_t next_tick_ = 0;                  ///< step at which ranks agree next
    std::int64_t outputs_owners_ = 0;             ///< distribution of bodies that outputs know
    bool idle_ = false, at_rest_ = false, stages_over_ = false, begins_branch_ = false;
};

} // namespace skein
