// Outputs of a run, each at steps of its own and at the last: a list, of which the run knows no kinds.
#pragma once

#include "core/timer.hpp"
#include "io/checkpoint.hpp"
#include "io/files.hpp"
#include "io/trajectory.hpp"
#include "io/vtk_series.hpp"
#include "simulation/fluid_frames.hpp"
#include "simulation/interaction.hpp"
#include "simulation/wall_meshes.hpp"
#include "skein/core/index.hpp"

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

class FluidInteraction;

/// The first multiple of `every` after `step`.
inline std::int64_t multiple_after(std::int64_t step, std::int64_t every) { return (step / every + 1) * every; }

/// The state that is written, which is that of synchronised copies.
struct Moment {
    std::int64_t step;
    double time, lag; ///< s
};

/// Calls are collective, but for next(), due() and files_of_end().
class Output {
public:
    virtual ~Output() = default;

    /// The first step after `done` at which it is due.
    virtual std::int64_t next(std::int64_t done) const = 0;
    virtual void write_due(const Moment& now) = 0;
    /// True where a state that has just been read is enough: others need the step that led there.
    virtual bool needs_state_alone() const { return true; }
    /// Names in the directory of what write_end() is to write, as EndRecord has them.
    virtual std::vector<std::string> files_of_end(std::int64_t step) const = 0;
    /// Writes what is not due at the run's last step.
    virtual void write_end(const Moment& now) = 0;
    /// Rods have new owners from now on.
    virtual void follow([[maybe_unused]] const Rods& rods) {}
    /// Puts what has been written on the disk, under final names.
    virtual void flush() {}
    /// Notes for a checkpoint how far it has come.
    virtual void mark([[maybe_unused]] CheckpointInfo& info) const {}
    virtual void finish() {}
    /// Says which of the records before a step an error has cost; empty: none.
    virtual std::string lost_before([[maybe_unused]] std::int64_t step) const { return std::string(); }
    /// True where it can show the step at which a failure began, as far as rods are made again.
    virtual bool shows_failure() const { return true; }
    virtual Phase phase() const { return Phase::output; }
};

using Outputs = std::vector<std::unique_ptr<Output>>;

/// An output of one interval.
class PeriodicOutput : public Output {
public:
    /// `every`: steps; 0: at the end alone.
    explicit PeriodicOutput(std::int64_t every) : every_(every) {}

    std::int64_t next(std::int64_t done) const override;
    void write_due(const Moment& now) override;
    std::vector<std::string> files_of_end(std::int64_t step) const override;
    void write_end(const Moment& now) override;

protected:
    bool due(std::int64_t step) const { return every_ > 0 && step % every_ == 0; }
    std::int64_t every() const { return every_; }
    virtual void write(const Moment& now) = 0;
    virtual std::vector<std::string> files_of(std::int64_t step) const = 0;

private:
    std::int64_t every_;
};

/// Frames of a trajectory or of tips.
class FrameOutput final : public PeriodicOutput {
public:
    FrameOutput(std::int64_t every, FrameKind kind, std::unique_ptr<FrameWriter> frames)
        : PeriodicOutput(every), kind_(kind), frames_(std::move(frames)) {}

    void follow(const Rods& rods) override { frames_->follow(rods); }
    void flush() override { frames_->close_segment(); }
    void mark(CheckpointInfo& info) const override;
    void finish() override { frames_->finish(); }
    std::string lost_before(std::int64_t step) const override;

private:
    void write(const Moment& now) override { frames_->write(now.step, now.time, now.lag); }
    std::vector<std::string> files_of(std::int64_t step) const override;
    std::string kind_name() const { return std::string(nth(frame_kind_names, kind_)); }

    FrameKind kind_;
    std::unique_ptr<FrameWriter> frames_;
};

/// Frames for ParaView, with walls where they move or have not been written.
class PolyDataOutput final : public PeriodicOutput {
public:
    /// `walls`: null where there are none to show.
    PolyDataOutput(std::int64_t every, std::unique_ptr<VtkSeries> frames, std::unique_ptr<WallMeshes> walls)
        : PeriodicOutput(every), frames_(std::move(frames)), walls_(std::move(walls)) {}

    void follow(const Rods& rods) override { frames_->follow(rods); }
    void flush() override { frames_->flush(); }
    void mark(CheckpointInfo& info) const override;

private:
    void write(const Moment& now) override;
    std::vector<std::string> files_of(std::int64_t step) const override;
    bool shows_walls() const { return walls_ && (walls_->move() || !frames_->has_walls()); }

    std::unique_ptr<VtkSeries> frames_;
    std::unique_ptr<WallMeshes> walls_;
};

/// Frames of a fluid, each kind at an interval of its own.
class FluidOutputs final : public Output {
public:
    FluidOutputs(std::unique_ptr<FluidFrames> frames, const FluidInteraction& fluid)
        : frames_(std::move(frames)), fluid_(fluid) {}
    bool shows_failure() const override { return false; }
    void mark(CheckpointInfo& info) const override { frames_->mark(info.last_frames); }

    std::int64_t next(std::int64_t done) const override { return frames_->next(done); }
    void write_due(const Moment& now) override;
    std::vector<std::string> files_of_end(std::int64_t step) const override { return frames_->files_of_end(step); }
    void write_end(const Moment& now) override;

private:
    std::unique_ptr<FluidFrames> frames_;
    const FluidInteraction& fluid_;
};

/// Tables of all contacts.
class ContactTables final : public PeriodicOutput {
public:
    ContactTables(std::int64_t every, const Communicator& comm, std::string directory, const Interactions& interactions)
        : PeriodicOutput(every), comm_(comm), directory_(std::move(directory)), interactions_(interactions) {}
    bool needs_state_alone() const override { return false; }

private:
    void write(const Moment& now) override;
    std::vector<std::string> files_of(std::int64_t step) const override;

    Communicator comm_;
    std::string directory_;
    const Interactions& interactions_; ///< made anew where a run goes back
};

/// Rows of observables.csv.
class SeriesOutput final : public PeriodicOutput {
public:
    /// Numbers of the row of this step; nothing where they are none. Collective.
    using Row = std::function<std::optional<std::span<const double>>()>;
    /// `file`: root's.
    SeriesOutput(std::int64_t every, const Communicator& comm, std::unique_ptr<SeriesFile> file, Row row)
        : PeriodicOutput(every), comm_(comm), file_(std::move(file)), row_(std::move(row)) {}

    bool needs_state_alone() const override { return false; }
    void flush() override;
    void mark(CheckpointInfo& info) const override;
    Phase phase() const override { return Phase::observe; }

private:
    void write(const Moment& now) override;
    std::vector<std::string> files_of(std::int64_t) const override { return {"observables.csv"}; }

    Communicator comm_;
    std::unique_ptr<SeriesFile> file_;
    Row row_;
};

} // namespace skein
