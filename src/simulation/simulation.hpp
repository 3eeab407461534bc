// A run: owns rods, clock and outputs, and carries out the plan. The readable step is Simulation::advance.
#pragma once

#include "core/error.hpp"
#include "core/timer.hpp"
#include "diagnostics/extra_observables.hpp"
#include "io/checkpoint.hpp"
#include "io/files.hpp"
#include "io/trajectory.hpp"
#include "io/vtk_series.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "rod/rods.hpp"
#include "scene/plan.hpp"
#include "simulation/interactions.hpp"
#include "simulation/progress.hpp"
#include "simulation/wall_meshes.hpp"
#include "time/clock.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// How steps, threads and ranks meet; the bits are the same.
enum class Protocol {
    asynchronous, ///< a tile takes many steps per visit, ranks meet at events: where no rod feels another
    synchronous   ///< one step per visit, all threads and ranks meet after it: what rods that feel each other would force
};
inline constexpr std::string_view protocol_names[] = {"asynchronous", "synchronous"};

struct RunOptions {
    std::string out;        ///< directory of results
    bool overwrite = false; ///< start anew over existing results
    std::int64_t steps = 0; ///< stop after this step; 0: the scene's end
    double until = 0;       ///< stop at this time, s; 0: the scene's end
    double walltime = 0;    ///< stop with a checkpoint after this many seconds; 0: never
    Protocol protocol = Protocol::asynchronous;
    bool checkpoint = true; ///< false: none is written, not even at the end; for timing
    bool quiet = false;     ///< no progress line
};

/// How a run ended.
struct RunResult {
    Exit code = Exit::done;
    std::int64_t step = 0;
    std::uint64_t digest = 0;
};

class Simulation {
public:
    /// Collective. Partitions the rods, takes the newest checkpoint in options.out, opens outputs. Throws before anything is
    /// overwritten where the directory holds something else.
    Simulation(const Communicator& comm, const Threads& threads, const SceneSpec& scene, std::vector<RodGroup> groups, Plan plan,
               RunOptions options);
    ~Simulation();

    /// Steps to the end (or a limit of the options), with outputs; writes checkpoint and summary. Throws NumericalError or IoError
    /// on all ranks alike.
    RunResult run();

    const Plan& plan() const { return plan_; }
    const Rods& rods() const { return *rods_; }
    std::int64_t step() const { return clock_.done(); }
    std::uint64_t digest() const; ///< of the whole scene; collective

    /// Steps up to `until` without looking at outputs: what a run does between two events.
    void advance(std::int64_t until);

private:
    /// Steps of rods that do not, many in a visit.
    bool step_alone(std::span<const Step> steps, bool check);
    /// Steps of rods that wait for each other. With `check`, false where a rod came out unfit.
    bool step_together(std::span<const Step> steps, bool check);
    enum class Verdict { go_on, warn, stop_at_limit, fail };

    void open_outputs(const SceneSpec& scene);
    /// Goes on with the audit of a checkpoint, or begins one here. Collective.
    void begin_audit(std::optional<double> audited_from);
    /// The same frames for ParaView, with walls where they move or at the beginning.
    void open_polydata(const SceneSpec& scene);
    void write_polydata();
    void write_due();
    void checkpoint();
    void sample();
    /// Tells once of strains and turns that the last sample shows to be near what the rod law or the discretisation bears.
    void warn_of_strain();
    /// The same of a step near the limit that strains leave; collective.
    void warn_of_limit();
    /// The same of overlaps beyond what the step allows for; collective.
    void warn_of_overlap();
    void warn(bool& told, bool bad, const std::string& text);
    /// Names and values of the series, collective.
    std::vector<std::string> names() const;
    std::vector<double> observables() const;
    std::int64_t next_event() const;
    /// All ranks learn of failures, signals, limits and what to be warned of; sets the next tick. Throws NumericalError where a
    /// rank failed.
    Verdict agree();
    /// By what happens in the scene, before its duration is over.
    bool ended() const;
    void look_for_rest();
    /// Where ranks meet after every step: false on all of them as soon as one has failed.
    bool meet();
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
    Timers timers_;
    double started_, setup_s_ = 0;
    std::unique_ptr<DirectoryLock> lock_;
    std::unique_ptr<Rods> rods_;
    std::unique_ptr<Interactions> interactions_; ///< null where rods heed nothing but their own loads
    Clock clock_;
    std::int64_t first_step_ = 0, last_step_ = 0; ///< of this run
    std::int64_t next_tick_ = 0;                  ///< step at which ranks agree next
    std::int64_t last_checkpoint_ = -1;
    std::string failure_, near_limit_; ///< of this rank's rods; agreed on at the next event
    std::unique_ptr<FrameWriter> trajectory_, tips_;
    std::unique_ptr<VtkSeries> polydata_;
    std::unique_ptr<WallMeshes> wall_meshes_; ///< null where there are no walls to show
    std::unique_ptr<SeriesFile> series_;      ///< root only
    std::vector<double> last_sample_;
    bool at_rest_ = false;
    bool told_turn_ = false, told_strain_ = false, told_tension_ = false, told_limit_ = false;
    std::unique_ptr<Progress> progress_;
};

/// Asks every run of this process to stop at its next event with a checkpoint. Safe in a signal handler.
void request_stop();

} // namespace skein
