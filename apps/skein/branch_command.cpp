#include "commands.hpp"
#include "document.hpp"

#include "partition/partition.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_rebuild.hpp"
#include "simulation/branch.hpp"
#include "simulation/summary.hpp"
#include "simulation/warnings.hpp"

#include "io/disk.hpp"
#include "io/files.hpp"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <filesystem>

namespace skein {

namespace {

namespace fs = std::filesystem;

/// Names of files that a scene takes, as seen from another folder.
void move_to(SceneSpec& scene, const fs::path& folder) {
    const fs::path was = fs::path(scene.file).parent_path();
    const auto move = [&](std::string& file) {
        if (!file.empty() && fs::path(file).is_relative()) file = fs::proximate(was / file, folder).string();
    };
    for (RodSpec& rods : scene.rods) move(rods.placement.file);
    for (AssemblySpec& assembly : scene.assemblies) move(assembly.placement.file);
    scene.file = (folder / "scene.toml").string();
}

/// The newest that is sound, or the one named.
CheckpointInfo parent_of(const Communicator& comm, const std::string& name) {
    const auto files = checkpoints_of(comm, name, "");
    for (const std::string& file : files) {
        try {
            return read_checkpoint_info(comm, file);
        } catch (const IoError& error) {
            if (&file == &files.back()) throw;
            if (comm.root()) print_warning(error.what());
        }
    }
    return {};
}

nlohmann::ordered_json json_of_branch(const std::string& scene, const std::string& parent, std::int64_t step,
                                      double time, const std::vector<KeyChange>& changes) {
    nlohmann::ordered_json changed = nlohmann::ordered_json::array();
    for (const KeyChange& c : changes) changed.push_back({{"key", c.key}, {"was", c.was}, {"now", c.now}});
    return {{"scene", scene}, {"parent", parent}, {"step", step}, {"time_s", time}, {"changes", changed}};
}

} // namespace

int branch_command(const BranchArguments& arguments, int& argc, char**& argv) {
    MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    return guarded(comm, [&] {
        const fs::path to = arguments.to;
        if (fs::exists(to) && !(fs::is_directory(to) && fs::is_empty(to)))
            throw IoError("'" + arguments.to + "' exists already: a branch begins in a new directory");
        const CheckpointInfo parent = parent_of(comm, arguments.from);
        const std::string directory = checkpoint_name(arguments.from).directory;
        const std::string from = fs::proximate(directory, to).string() + "@" + std::to_string(parent.step);
        SceneSpec scene = branched_scene(parent.scene, parent.settings, parent.file, from, arguments.overrides);

        // All that a run of it would refuse is refused here, before anything is written.
        std::vector<RodGroup> groups = make_groups(scene);
        read_rods(comm, groups);
        scene = resolved(std::move(scene), groups);
        const Plan plan = make_plan(scene, groups, {});
        const std::string physics = physics_json(scene, groups, plan.dt);
        refuse_other_rods(parent, physics);
        auto changes = key_changes(parent.scene, physics);
        std::erase_if(changes, [](const KeyChange& c) { return c.key.starts_with("start."); });
        move_to(scene, to);
        on_root(comm, [&] {
            fs::create_directories(to);
            write_file(scene.file, branch_file(scene, parent, changes));
            const double time = parent.shift + static_cast<double>(parent.step) * parent.dt;
            if (arguments.json)
                return print_document(json_of_branch(scene.file, directory, parent.step, time, changes));
            std::printf("%s begins with step %lld of %s, t = %g s%s%s\nRun it: skein run %s\n", scene.file.c_str(),
                        static_cast<long long>(parent.step), directory.c_str(), time,
                        changes.empty() ? "" : "; changed:", text_of(changes).c_str(), arguments.to.c_str());
        });
        return static_cast<int>(Exit::done);
    });
}

} // namespace skein
