#include "simulation/outputs.hpp"

#include "io/disk.hpp"
#include "io/own_files.hpp"
#include "simulation/contact_interaction.hpp"
#include "simulation/fluid_interaction.hpp"

#include <fmt/format.h>

namespace skein {

std::int64_t PeriodicOutput::next(std::int64_t done) const {
    return every_ > 0 ? multiple_after(done, every_) : std::numeric_limits<std::int64_t>::max();
}

void PeriodicOutput::write_due(const Moment& now) {
    if (due(now.step)) write(now);
}

std::vector<std::string> PeriodicOutput::files_of_end(std::int64_t step) const {
    return due(step) ? std::vector<std::string>() : files_of(step);
}

void PeriodicOutput::write_end(const Moment& now) {
    if (!due(now.step)) write(now);
}

void FrameOutput::mark(CheckpointInfo& info) const {
    (kind_ == FrameKind::trajectory ? info.last_trajectory : info.last_tips) = frames_->last_step();
}

std::string FrameOutput::lost_before(std::int64_t step) const {
    const std::int64_t last = frames_->last_step(),
                       first = last < 0 || every() == 0 ? 0 : multiple_after(last, every());
    if (every() == 0 || first >= step) return {};
    return fmt::format(
        "\n  {} frames of steps {} to {} are lost; to have them computed again, move this checkpoint away", kind_name(),
        first, (step - 1) / every() * every());
}

std::vector<std::string> FrameOutput::files_of(std::int64_t step) const {
    return {fmt::format("{}_{:012d}.h5", kind_name(), step)};
}

void PolyDataOutput::write(const Moment& now) {
    frames_->write(now.step, now.time, now.lag);
    if (shows_walls()) frames_->write_walls(now.step, now.time, walls_->at(now.time));
}

void PolyDataOutput::mark(CheckpointInfo& info) const {
    info.last_frames["rods"] = frames_->last_rods();
    if (walls_) info.last_frames["walls"] = frames_->last_walls();
}

std::vector<std::string> PolyDataOutput::files_of(std::int64_t step) const {
    std::vector<std::string> names{VtkSeries::frame_name("rods", step)};
    if (shows_walls()) names.push_back(VtkSeries::frame_name("walls", step));
    return names;
}

void FluidOutputs::write_due(const Moment& now) { frames_->write_due(now.step, fluid_.box_shift()); }

void FluidOutputs::write_end(const Moment& now) { frames_->write_end(now.step, fluid_.box_shift()); }

void ContactTables::write(const Moment& now) {
    if (now.step > 0)
        write_file(comm_, directory_ + "/" + files_of(now.step).front(), contacts_of(interactions_)->table());
}

std::vector<std::string> ContactTables::files_of(std::int64_t step) const {
    return {fmt::format("contacts_{:012d}.csv", step)};
}

void SeriesOutput::write(const Moment& now) {
    const auto numbers = row_();
    on_root(comm_, [&] {
        if (numbers) file_->append(now.step, now.time, *numbers);
    });
}

void SeriesOutput::flush() {
    on_root(comm_, [&] { file_->flush(); });
}

void SeriesOutput::mark(CheckpointInfo& info) const {
    const SeriesMark mine = file_ ? file_->mark() : SeriesMark{};
    info.series = SeriesMark{static_cast<std::uint64_t>(comm_.broadcast(static_cast<std::int64_t>(mine.bytes))),
                             static_cast<std::uint64_t>(comm_.broadcast(static_cast<std::int64_t>(mine.digest))),
                             comm_.broadcast(mine.row)};
}

} // namespace skein
