// The outputs of a run: which there are, and when they are written.
#include "diagnostics/observables.hpp"
#include "io/disk.hpp"
#include "io/end_record.hpp"
#include "simulation/simulation.hpp"

#include <cmath>

namespace skein {

namespace {

/// Step of the last frame of a series that a checkpoint knows of.
std::optional<std::int64_t> last_frame(const CheckpointInfo* resumed, const std::string& series) {
    if (!resumed || !resumed->last_frames.contains(series)) return {};
    return resumed->last_frames.at(series);
}

} // namespace

void Simulation::open_outputs(const SceneSpec& scene, const CheckpointInfo* resumed) {
    on_root(comm_, [&] { take_back_end(options_.out); });
    const std::int64_t step = resumed ? clock_.done() : -1;
    const Cadence& every = plan_.cadence;
    const auto add_frames = [&](FrameKind kind, std::int64_t interval,
                                std::optional<std::int64_t> CheckpointInfo::*last) {
        outputs_.push_back(std::make_unique<FrameOutput>(
            interval, kind,
            std::make_unique<FrameWriter>(comm_, options_.out, kind, scene.output, groups_, *rods_, step, plan_.title,
                                          FrameWriter::default_buffer_bytes, print_warning,
                                          resumed ? resumed->*last : std::nullopt)));
    };
    if (every.series > 0 || plan_.relax) {
        std::unique_ptr<SeriesFile> file;
        on_root(comm_, [&] {
            file =
                std::make_unique<SeriesFile>(options_.out + "/observables.csv", names(), step,
                                             resumed && resumed->series ? &*resumed->series : nullptr, print_warning);
        });
        outputs_.push_back(
            std::make_unique<SeriesOutput>(every.series, comm_, std::move(file), [this] { return row(); }));
    }
    if (every.trajectory > 0 || plan_.relax)
        add_frames(FrameKind::trajectory, every.trajectory, &CheckpointInfo::last_trajectory);
    if (plan_.vtp) outputs_.push_back(polydata(scene, resumed));
    if (every.tips > 0) add_frames(FrameKind::tips, every.tips, &CheckpointInfo::last_tips);
    if (plan_.fluid && !plan_.fluid->outputs.empty()) {
        const FluidInteraction& fluid = *fluid_of(interactions_);
        outputs_.push_back(std::make_unique<FluidOutputs>(
            std::make_unique<FluidFrames>(
                comm_, threads_, fluid.flow(), *plan_.fluid, options_.out, plan_.dt, clock_.shift(),
                [&](const std::string& name) {
                    return FieldSeries::Earlier{step, last_frame(resumed, name), print_warning};
                }),
            fluid));
    }
    if (every.contacts > 0)
        outputs_.push_back(std::make_unique<ContactTables>(every.contacts, comm_, options_.out, interactions_));
}

std::unique_ptr<Output> Simulation::polydata(const SceneSpec& scene, const CheckpointInfo* resumed) {
    NodeForces forces;
    if (contacts_of(interactions_))
        forces = [this](std::int64_t gid, std::span<Vec3d> out) { contacts_of(interactions_)->forces(gid, out); };
    auto frames = std::make_unique<VtkSeries>(
        comm_, options_.out, scene.output, groups_, *rods_, resumed ? clock_.done() : -1, std::move(forces),
        VtkSeries::Expected{last_frame(resumed, "rods"), last_frame(resumed, "walls")}, print_warning);
    std::unique_ptr<WallMeshes> walls;
    if (walls_) walls = std::make_unique<WallMeshes>(comm_, *walls_, groups_, rods_->local());
    return std::make_unique<PolyDataOutput>(plan_.cadence.trajectory, std::move(frames), std::move(walls));
}

void Simulation::write_due() {
    if (due(plan_.cadence.series)) sample();
    for (const auto& output : outputs_) {
        const auto timing = timers_.time(output->phase());
        output->write_due(now());
    }
    if (clock_.done() > 0 && (due(plan_.cadence.checkpoint) || save_now_)) checkpoint();
    else if (close_now_) close_files();
    save_now_ = close_now_ = false;
}

void Simulation::write_due_of_state() {
    const auto timing = timers_.time(Phase::output);
    for (const auto& output : outputs_)
        if (output->needs_state_alone()) output->write_due(now());
}

void Simulation::write_end(bool failed) {
    const auto timing = timers_.time(Phase::output);
    const auto shows = [failed](const Output& output) { return !failed || output.shows_failure(); };
    EndRecord record{clock_.done(), {}};
    for (const auto& output : outputs_)
        if (shows(*output))
            for (std::string& name : output->files_of_end(clock_.done())) record.files.push_back(std::move(name));
    if (!record.files.empty()) {
        close_files(); // what is taken back later is in files of its own
        on_root(comm_, [&] { write_end_record(options_.out, record); });
        for (const auto& output : outputs_)
            if (shows(*output)) output->write_end(now());
        close_files();
    }
    finish_files();
}

void Simulation::finish_files() {
    for (const auto& output : outputs_) output->finish();
}

Moment Simulation::now() const { return {clock_.done(), clock_.time(), clock_.lag()}; }

std::optional<std::span<const double>> Simulation::row() {
    take_sample();
    const bool numbers = std::isfinite(
        groups_.empty() ? last_sample_.front()
                        : observed_energy(last_sample_)); // of a copy half a step on, which may fail first
    warn(warned_row_, !numbers, "an energy is not a number: the time series has no row of this step");
    return numbers ? std::optional<std::span<const double>>(last_sample_) : std::nullopt;
}

void Simulation::close_files() {
    const auto timing = timers_.time(Phase::output);
    for (const auto& output : outputs_) output->flush();
    frames_closed_ = wall_seconds();
}

} // namespace skein
