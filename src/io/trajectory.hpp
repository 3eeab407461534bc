// Trajectories: HDF5 frames (docs/files.md) with an XDMF side-car for ParaView. Frames between two checkpoints make one
// segment file, trajectory_<first step, 12 digits>.h5. It is written as *.tmp and renamed just before the checkpoint,
// so a killed run leaves no broken file. Later frames are computed again bit for bit. Frames wait in memory and are
// written many at a time, because a parallel write costs milliseconds beside its bytes, more than a small frame.
#pragma once

#include "io/frame_files.hpp"
#include "io/output_spec.hpp"
#include "parallel/communicator.hpp"
#include "tiles/rods.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace skein {

/// Writes one frame of all rods in double precision with directors, as the trajectory file <directory>/<name>.h5 with
/// the side-car <name>.xdmf. Collective.
void write_single_frame(const Communicator& comm, const std::string& directory, const std::string& name,
                        std::span<const RodGroup> groups, const Rods& rods, const std::string& title, std::int64_t step,
                        double time, double lag);

class FrameWriter {
public:
    /// Bytes of frames that wait in memory, per rank. Buffers of records take up to twice that, and those for other
    /// ranks twice more while a field is written.
    static constexpr std::uint64_t default_buffer_bytes = 32 << 20;
    /// Bytes of frames of all ranks between two flushes of the file's tables, which a killed run may leave unreadable.
    static constexpr std::uint64_t default_flush_bytes = 64 << 20;
    struct Settings {
        std::string directory;
        FrameKind kind = FrameKind::trajectory;
        OutputSpec spec = {};
        std::string title = {};
        EarlierFrames earlier = {}; ///< later frames and unfinished segments are renamed to lost_*
        std::uint64_t buffer_bytes = default_buffer_bytes, flush_bytes = default_flush_bytes;
    };
    /// Continues earlier frames. Unreadable segments, and a last one with a damaged frame, are renamed to *.damaged.
    /// `groups` and `rods` must outlive the writer. Collective.
    FrameWriter(const Communicator& comm, Settings settings, std::span<const RodGroup> groups, const Rods& rods);
    ~FrameWriter();

    /// Appends the state at a time, in copies whose positions drift by `lag`. Steps that exist are skipped. An error
    /// may belong to an earlier frame. Collective.
    void write(std::int64_t step, double time, double lag);
    /// Takes rods with new owners, which must outlive the writer. Collective.
    void rebind(const Rods& rods);
    /// Closes and renames the open segment, before each checkpoint and at the end. A segment that is still open when
    /// the object ends is lost. The side-car is rewritten if it lags by a sixteenth of the segments. All its versions
    /// together are then in proportion to the last one. Collective.
    void close_segment();
    /// Updates the side-car. Collective.
    void finish();
    /// Step of the last frame in a file, or in the open segment; -1: none. After an error in write() or close_segment()
    /// the open segment does not count.
    std::int64_t last_step() const;

private:
    friend void write_single_frame(const Communicator&, const std::string&, const std::string&,
                                   std::span<const RodGroup>, const Rods&, const std::string&, std::int64_t, double,
                                   double);
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace skein
