#include "simulation/checkpoint_output.hpp"

#include "io/disk.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

namespace skein {

CheckpointOutput::CheckpointOutput(const OutputParts& parts)
    : world_(parts.world), stages_(parts.stages), observation_(parts.observation), others_(parts.outputs),
      texts_(parts.texts), options_(parts.options), clock_(parts.plan().cadence.checkpoint_wall, parts.started,
                                                           parts.plan().state_bytes / parts.plan().machine.ranks),
      every_{parts.plan().cadence.of("checkpoint")}, frames_wall_(parts.plan().cadence.frames_wall) {
    if (!parts.resumed) return;
    last_ = parts.resumed->step;
    digest_ = parts.resumed->digest;
}

bool CheckpointOutput::due(const Moment& now) const {
    return (now.step > 0 && (every_.due(now.step) || save_now_)) || flush_now_;
}

void CheckpointOutput::tick() {
    const auto on_root = [&](bool yes) { return world_.comm.broadcast(static_cast<std::int64_t>(yes)) != 0; };
    if (clock_.every() > 0) save_now_ = on_root(clock_.due());
    if (frames_wall_ > 0) flush_now_ = on_root(wall_seconds() - flushed_ >= frames_wall_);
}

void CheckpointOutput::write(const Moment& now) {
    const bool only_flush = std::exchange(flush_now_, false) && !every_.due(now.step) && !save_now_;
    save_now_ = false;
    if (!only_flush && last_ == now.step) return;
    const double began = wall_seconds();
    flush_others();
    world_.timers.move(phase(), Phase::output, flushed_ - began);
    if (!only_flush) write_state(now);
}

void CheckpointOutput::flush_others() {
    for (const auto& output : others_)
        if (output.get() != this) output->flush();
    flushed_ = wall_seconds();
}

bool CheckpointOutput::late() {
    clock_.update();
    return options_.walltime > 0 && clock_.late(options_.walltime);
}

void CheckpointOutput::write_state(const Moment& now) {
    if (!options_.checkpoint) return;
    clock_.begin_saving();
    saving_ = true; // an error from here on is that of a checkpoint
    digest_ = world_.digest();
    CheckpointInfo info{now.step, world_.plan.dt, digest_, texts_.physics, {}, observation_.audited_from()};
    info.shift = world_.clock.shift();
    info.settings = texts_.settings;
    info.ancestry = texts_.ancestry;
    info.beyond = world_.comm.sum_wrapping(digest_of(world_.interactions()));
    info.saved = saved(world_.interactions());
    info.stage_begins = stages_.begins();
    info.stage_over = !stages_.over().empty();
    if (info.stage_over) {
        const auto [defect, contacts] = observation_.left();
        info.stage_defect = defect;
        info.stage_contacts = contacts;
    }
    info.stage_work = observation_.stage_work();
    for (const auto& output : others_) output->mark(info);
    write_checkpoint(world_.comm, options_.out, world_.groups, world_.rods(), info, world_.plan.keeping);
    last_ = now.step;
    saving_ = false;
    clock_.end_saving();
}

std::string CheckpointOutput::rescue(const Moment& now) {
    if (saving_ || !options_.checkpoint || last_ == now.step) return {};
    for (const auto& output : others_) try {
            output->flush();
        } catch (const IoError&) { // the first error is the one that is reported
        }
    try {
        write_state(now);
    } catch (const IoError& error) {
        return fmt::format("\n  there is no last checkpoint either: {}", error.what());
    }
    std::string text = fmt::format(
        "\n  the state of step {} is kept in a last checkpoint, from which the same command continues", now.step);
    for (const auto& output : others_) text += output->lost_before(now.step);
    return text;
}

std::unique_ptr<Output> make_checkpoints(const OutputParts& parts) { return std::make_unique<CheckpointOutput>(parts); }

} // namespace skein
