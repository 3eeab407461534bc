// Outputs of a run: a list whose members the run does not know. A new one is a file that defines a maker, and the
// maker's name in output_list.cpp.
#pragma once

#include "core/timer.hpp"
#include "io/checkpoint.hpp"
#include "physics/scene_spec.hpp"
#include "simulation/observation.hpp"
#include "simulation/run_options.hpp"
#include "simulation/stages.hpp"
#include "simulation/warnings.hpp"
#include "simulation/world.hpp"
#include "time/every.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Time of what is written, which is a synchronised copy of the state.
struct Moment {
    std::int64_t step;
    double time, lag; ///< s
};

/// Calls are collective, but for next(), due() and files_of_end().
class Output {
public:
    virtual ~Output() = default;

    /// First step after `done` at which it is due.
    virtual std::int64_t next([[maybe_unused]] std::int64_t done) const { return Every::never; }
    virtual bool due(const Moment& now) const = 0;
    virtual void write(const Moment& now) = 0;
    /// About once a second of wall time, where ranks agree.
    virtual void tick() {}
    /// True where a state that has just been read is enough: others need the step that led there.
    virtual bool needs_state_alone() const { return true; }
    /// Names in the directory of the files that write_end() writes, as EndRecord has them.
    virtual std::vector<std::string> files_of_end([[maybe_unused]] std::int64_t step) const { return {}; }
    /// Writes the part that is not due at the run's last step.
    virtual void write_end([[maybe_unused]] const Moment& now) {}
    /// Rebinds the output to bodies that have new owners, or that a stage has rebuilt with its groups and plan.
    virtual void rebind([[maybe_unused]] const Rods& rods) {}
    /// Puts on the disk, under final names, all that has been written.
    virtual void flush() {}
    /// Notes for a checkpoint how far it has come.
    virtual void mark([[maybe_unused]] CheckpointInfo& info) const {}
    virtual void finish() {}
    /// Names those records before a step that an error has cost; empty: none.
    virtual std::string lost_before([[maybe_unused]] std::int64_t step) const { return {}; }
    /// True where it can show the step at which a failure began, for which bodies alone are made again.
    virtual bool shows_failure() const { return true; }
    virtual Phase phase() const { return Phase::output; }
};

using Outputs = std::vector<std::unique_ptr<Output>>;

/// An output of one interval, which writes the last step too.
class PeriodicOutput : public Output {
public:
    /// `every`: steps; 0: at the end alone.
    explicit PeriodicOutput(std::int64_t every) : every_{every} {}

    std::int64_t next(std::int64_t done) const override { return every_.next(done); }
    bool due(const Moment& now) const override { return every_.due(now.step); }
    std::vector<std::string> files_of_end(std::int64_t step) const override {
        return every_.due(step) ? std::vector<std::string>() : files_of(step);
    }
    void write_end(const Moment& now) override {
        if (!due(now)) write(now);
    }

protected:
    const Every& every() const { return every_; }
    virtual std::vector<std::string> files_of(std::int64_t step) const = 0;

private:
    Every every_;
};

/// Texts of a scene that checkpoints and the summary keep.
struct SceneTexts {
    std::string physics;  ///< canonical scene
    std::string settings; ///< the rest of it
    std::string output;   ///< its [output]
    std::string ancestry; ///< of a branch, JSON
};

/// Parts of a run that outputs are made from, which must outlive them.
struct OutputParts {
    const SceneSpec& scene;
    World& world;
    const Stages& stages;
    Observation& observation;
    Warnings& warnings;
    Outputs& outputs; ///< those before it in the list
    const SceneTexts& texts;
    const RunOptions& options;
    double started;                                ///< wall_seconds() from which the run's time counts
    std::int64_t last_step;                        ///< of the run
    std::span<const std::size_t> progress_columns; ///< columns of the series that the progress line shows
    const CheckpointInfo* resumed; ///< checkpoint of this directory that the run resumes from; null: none

    const Communicator& comm() const { return world.comm; }
    const Plan& plan() const { return world.plan; }
    /// Step that the files are resumed from; -1: they begin anew.
    std::int64_t resumed_step() const { return resumed ? world.clock.done() : -1; }
    /// Step of the last frame of a series that the checkpoint knows of.
    std::optional<std::int64_t> last_frame(const std::string& series) const {
        if (!resumed || !resumed->last_frames.contains(series)) return {};
        return resumed->last_frames.at(series);
    }
};

/// Appends the outputs that a run's plan asks for, in the order in which they are written. Collective.
void make_outputs(const OutputParts& parts);

} // namespace skein
