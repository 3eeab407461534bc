// What a simulation saves of a run that an I/O error ends, and what is told of it.
#include "simulation/simulation.hpp"

#include <fmt/format.h>

namespace skein {

namespace {

/// Frames between those on the disk and this step. The frame of this step itself is written when the run goes on.
std::string lost_frames(const FrameWriter* frames, std::int64_t every, std::int64_t step, const char* kind) {
    if (!frames) return {};
    const std::int64_t last = frames->last_step(), first = last < 0 ? 0 : (last / every + 1) * every;
    if (first >= step) return {};
    return fmt::format("\n  {} frames of steps {} to {} are lost; to have them computed again, move this checkpoint away", kind,
                       first, (step - 1) / every * every);
}

} // namespace

std::string Simulation::save_what_can_be_saved() {
    if (saving_ || !options_.checkpoint || last_checkpoint_ == clock_.done()) return {};
    for (FrameWriter* frames : {trajectory_.get(), tips_.get()})
        if (frames) try {
                frames->close_segment();
            } catch (const IoError&) { // the first error is the one that is told
            }
    if (polydata_) try {
            polydata_->flush();
        } catch (const IoError&) {
        }
    try {
        keep_state();
    } catch (const IoError& error) {
        return fmt::format("\n  there is no last checkpoint either: {}", error.what());
    }
    return fmt::format("\n  the state of step {} is kept in a last checkpoint, from which the same command goes on{}{}",
                       clock_.done(), lost_frames(trajectory_.get(), plan_.cadence.trajectory, clock_.done(), "trajectory"),
                       lost_frames(tips_.get(), plan_.cadence.tips, clock_.done(), "tips"));
}

void Simulation::mark_outputs(CheckpointInfo& info) const {
    if (plan_.cadence.series > 0) {
        const SeriesMark mine = series_ ? series_->mark() : SeriesMark{};
        info.series = SeriesMark{static_cast<std::uint64_t>(comm_.broadcast(static_cast<std::int64_t>(mine.bytes))),
                                 static_cast<std::uint64_t>(comm_.broadcast(static_cast<std::int64_t>(mine.digest))),
                                 comm_.broadcast(mine.row)};
    }
    if (trajectory_) info.last_trajectory = trajectory_->last_step();
    if (tips_) info.last_tips = tips_->last_step();
}

} // namespace skein
