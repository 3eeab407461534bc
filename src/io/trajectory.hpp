// Trajectories: HDF5 frames in our own schema (docs/files.md) with an XDMF side-car that ParaView opens.
// Frames between two checkpoints make one segment file, trajectory_<first step, 12 digits>.h5, written as *.tmp and
// renamed when it is closed just before the checkpoint: a killed run never leaves a broken file, and what came after
// the last checkpoint is computed again, bit for bit. Frames wait in memory and are written many at a time: what a
// parallel write costs beside its bytes, some milliseconds, is far more than a small frame.
#pragma once

#include "io/output_spec.hpp"
#include "parallel/communicator.hpp"
#include "tiles/rods.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace skein {

/// Writes one frame of all rods as they are, in double precision with directors, as <directory>/<name>.h5 with a
/// side-car <name>.xdmf of its own: laid out as a trajectory file. Collective.
void write_single_frame(const Communicator& comm, const std::string& directory, const std::string& name,
                        std::span<const RodGroup> groups, const Rods& rods, const std::string& title, std::int64_t step,
                        double time, double lag);

class FrameWriter {
public:
    using Warn = std::function<void(const std::string&)>;
    /// Keeps the frames of the directory up to `resume_step` (-1: none), and puts others and unfinished segments aside
    /// under names that begin with lost_. Segments that cannot be read, and a last one whose frames are not what was
    /// written, are put aside as *.damaged. `warn` (called on root) is told of these and of frames that are missing;
    /// `expected` is the last frame that there should be, where that is known. Collective.
    FrameWriter(const Communicator& comm, std::string directory, FrameKind kind, const OutputSpec& spec,
                std::span<const RodGroup> groups, const Rods& rods, std::int64_t resume_step, std::string title,
                std::uint64_t buffer_bytes = default_buffer_bytes, Warn warn = {},
                std::optional<std::int64_t> expected = {}, std::uint64_t flush_bytes = default_flush_bytes);
    /// Of frames that wait in memory, per rank. Buffers of records that stay and of those that go to other ranks are up
    /// to twice that, and the latter are there twice more while a field is written.
    static constexpr std::uint64_t default_buffer_bytes = 32 << 20;
    /// Of frames of all ranks between two flushes of the file's tables: what a killed run leaves unreadable.
    static constexpr std::uint64_t default_flush_bytes = 64 << 20;
    ~FrameWriter();

    /// Appends the state at time t (synchronised copies: positions drifted on by `lag`). A step that is already there
    /// is left alone. An error may be that of an earlier frame. Collective.
    void write(std::int64_t step, double time, double lag);
    /// Rods have new owners from now on. `rods` must outlive it. Collective.
    void follow(const Rods& rods);
    /// Closes and renames the open segment. Called before each checkpoint and at the end: what is still open when the
    /// object ends is lost. The XDMF side-car is rewritten when it lags by a sixteenth of the segments, so that all its
    /// versions together are in proportion to the last one. Collective.
    void close_segment();
    /// Brings the side-car up to date. Collective.
    void finish();
    /// Step of the last frame that is in a file or will be with the next close_segment(); -1: none. After an error in
    /// write() or close_segment(): of the last one that is in a file.
    std::int64_t last_step() const;

private:
    friend void write_single_frame(const Communicator&, const std::string&, const std::string&,
                                   std::span<const RodGroup>, const Rods&, const std::string&, std::int64_t, double,
                                   double);
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace skein
