// Frames for ParaView, with walls where these change in the run or have not been written.
#include "io/vtk_series.hpp"
#include "physics/contact/contact_interaction.hpp"
#include "scene/scene_stages.hpp"
#include "simulation/output.hpp"
#include "simulation/wall_meshes.hpp"

#include <algorithm>
#include <memory>

namespace skein {

namespace {

class PolyDataOutput final : public PeriodicOutput {
public:
    /// `walls`: null where there are none to show; `change`: a frame of them is needed at each time.
    PolyDataOutput(std::int64_t every, std::unique_ptr<VtkSeries> frames, std::unique_ptr<WallMeshes> walls,
                   bool change)
        : PeriodicOutput(every), frames_(std::move(frames)), walls_(std::move(walls)), walls_change_(change) {}

    void write(const Moment& now) override {
        frames_->write(now.step, now.time, now.lag);
        if (shows_walls()) frames_->write_walls(now.step, now.time, walls_->at(now.time));
    }
    void rebind(const Rods& rods) override { frames_->rebind(rods); }
    void flush() override { frames_->flush(); }
    void mark(CheckpointInfo& info) const override {
        info.last_frames["rods"] = frames_->last_rods();
        if (walls_) info.last_frames["walls"] = frames_->last_walls();
    }

private:
    std::vector<std::string> files_of(std::int64_t step) const override {
        std::vector<std::string> names{VtkSeries::frame_name("rods", step)};
        if (shows_walls()) names.push_back(VtkSeries::frame_name("walls", step));
        return names;
    }
    bool shows_walls() const { return walls_ && (walls_change_ || !frames_->has_walls()); }

    std::unique_ptr<VtkSeries> frames_;
    std::unique_ptr<WallMeshes> walls_;
    bool walls_change_;
};

/// True where a wall moves in some stage, or stands in some stages alone: so it is in all parts of a run alike.
bool walls_change(const SceneSpec& scene) {
    const auto changes = [](const Wall& wall) { return wall.servo.drives() || wall.moves_steadily() || !wall.stands; };
    for (std::size_t stage = 0; stage < std::max<std::size_t>(1, scene.stages.size()); ++stage) {
        const SceneSpec now = stage_scene(scene, nominal_begins(scene, stage));
        if (std::any_of(now.walls.begin(), now.walls.end(), changes)) return true;
    }
    return false;
}

} // namespace

std::unique_ptr<Output> make_poly_data(const OutputParts& parts) {
    if (!parts.plan().vtp) return nullptr;
    const World& world = parts.world;
    NodeForces forces;
    if (contacts_of(world.interactions()))
        forces = [&world](std::int64_t gid, std::span<Vec3d> out) {
            contacts_of(world.interactions())->forces(gid, out); // contacts are made anew where a run goes back
        };
    auto frames = std::make_unique<VtkSeries>(
        world.comm, parts.options.out, parts.scene.output, world.groups, world.rods(), std::move(forces),
        EarlierFrames{parts.resumed_step(), parts.last_frame("rods"), print_warning}, parts.last_frame("walls"));
    std::unique_ptr<WallMeshes> walls;
    if (world.walls())
        walls = std::make_unique<WallMeshes>(world.comm, *world.walls(), world.groups, world.rods().local());
    return std::make_unique<PolyDataOutput>(parts.plan().cadence.of("trajectory"), std::move(frames), std::move(walls),
                                            walls_change(parts.scene));
}

} // namespace skein
