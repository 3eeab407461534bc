// Frames of a trajectory or of tips, in HDF5.
#include "io/trajectory.hpp"
#include "simulation/output.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

namespace skein {

namespace {

class FrameOutput final : public PeriodicOutput {
public:
    FrameOutput(std::int64_t every, FrameKind kind, std::unique_ptr<FrameWriter> frames)
        : PeriodicOutput(every), kind_(kind), frames_(std::move(frames)) {}

    void write(const Moment& now) override { frames_->write(now.step, now.time, now.lag); }
    void rebind(const Rods& rods) override { frames_->rebind(rods); }
    void flush() override { frames_->close_segment(); }
    void mark(CheckpointInfo& info) const override {
        (kind_ == FrameKind::trajectory ? info.last_trajectory : info.last_tips) = frames_->last_step();
    }
    void finish() override { frames_->finish(); }
    std::string lost_before(std::int64_t step) const override;

private:
    std::vector<std::string> files_of(std::int64_t step) const override {
        return {fmt::format("{}_{:012d}.h5", nth(frame_kind_names, kind_), step)};
    }

    FrameKind kind_;
    std::unique_ptr<FrameWriter> frames_;
};

std::string FrameOutput::lost_before(std::int64_t step) const {
    const std::int64_t last = frames_->last_step(), first = last < 0 ? 0 : every().next(last);
    if (every().steps == 0 || first >= step) return {};
    return fmt::format(
        "\n  {} frames of steps {} to {} are lost; to have them computed again, move this checkpoint away",
        nth(frame_kind_names, kind_), first, every().last(step - 1));
}

std::unique_ptr<Output> make_frames(const OutputParts& parts, FrameKind kind, std::int64_t every,
                                    std::optional<std::int64_t> CheckpointInfo::*last) {
    const std::optional<std::int64_t> last_frame = parts.resumed ? parts.resumed->*last : std::nullopt;
    const FrameWriter::Settings settings{.directory = parts.options.out,
                                         .kind = kind,
                                         .spec = parts.scene.output,
                                         .title = parts.plan().title,
                                         .earlier = {parts.resumed_step(), last_frame, print_warning}};
    return std::make_unique<FrameOutput>(
        every, kind, std::make_unique<FrameWriter>(parts.comm(), settings, parts.world.groups, parts.world.rods()));
}

} // namespace

std::unique_ptr<Output> make_trajectory(const OutputParts& parts) {
    const std::int64_t every = parts.plan().cadence.of("trajectory");
    if (every == 0 && !parts.plan().pseudo_time) return nullptr;
    return make_frames(parts, FrameKind::trajectory, every, &CheckpointInfo::last_trajectory);
}

std::unique_ptr<Output> make_tips(const OutputParts& parts) {
    const std::int64_t every = parts.plan().cadence.of("tips");
    return every > 0 ? make_frames(parts, FrameKind::tips, every, &CheckpointInfo::last_tips) : nullptr;
}

} // namespace skein
