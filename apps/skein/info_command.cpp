// What is known of the build, of a scene, of a run's results, and of the keys of scenes.
#include "commands.hpp"

#include "core/level.hpp"
#include "io/checkpoint.hpp"
#include "io/disk.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "scene/scene_description.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_rebuild.hpp"
#include "simulation/progress.hpp"
#include "simulation/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <thread>

namespace skein {

namespace {

namespace fs = std::filesystem;

bool holds_results(const std::string& directory) {
    std::error_code error;
    return fs::is_directory(directory, error) && (fs::is_regular_file(directory + "/physics.json", error) ||
                                                  !numbered_files(directory, "checkpoint_", ".h5").empty());
}

/// A file, or a directory without results and without the scene of a branch, is none: the message says what would do.
void refuse_other_directory(const std::string& directory) {
    std::error_code error;
    if (fs::is_directory(directory, error) && !fs::is_regular_file(fs::path(directory) / "scene.toml", error))
        throw InputError(fmt::format("{}: holds no results (physics.json, checkpoint_*.h5) and no scene.toml; give a "
                                     "scene or the directory of a run",
                                     directory));
}

/// The newest checkpoint of a directory that can be read, and the scene that it keeps.
struct Kept {
    CheckpointInfo info;
    SceneSpec scene;
    std::size_t files;
};

Kept kept_in(const std::string& directory, int& argc, char**& argv) {
    const char* const ranks = std::getenv("OMPI_COMM_WORLD_SIZE");
    if (ranks && std::atoi(ranks) > 1)
        throw InputError("results are looked at by one process: start it without mpirun");
    const MpiSession session(argc, argv);
    const Communicator comm = Communicator::world();
    auto files = numbered_files(directory, "checkpoint_", ".h5");
    if (files.empty())
        throw InputError(fmt::format("{}: there is no checkpoint in it, which keeps the scene of a run", directory));
    std::reverse(files.begin(), files.end());
    for (const NumberedFile& file : files) {
        try {
            const CheckpointInfo info = read_checkpoint_info(comm, directory + "/" + file.name);
            return {info, rebuilt_scene(info.scene, info.settings, info.file), files.size()};
        } catch (const IoError& error) {
            if (&file == &files.back()) throw;
            std::fprintf(stderr, "warning: %s\n", error.what());
        }
    }
    return {};
}

void tell_results(const std::string& directory, int& argc, char**& argv) {
    std::printf("%s: results of a run\n", directory.c_str());
    if (numbered_files(directory, "checkpoint_", ".h5").empty()) {
        std::printf("  no checkpoint yet: the same command begins at the start\n");
    } else {
        const Kept kept = kept_in(directory, argc, argv);
        const double time = kept.info.shift + static_cast<double>(kept.info.step) * kept.info.dt;
        const auto steps =
            static_cast<std::int64_t>(std::llround((kept.scene.time.duration - kept.info.shift) / kept.info.dt));
        std::printf("  scene '%s', from %s\n", kept.scene.title.c_str(),
                    kept.scene.file.empty() ? "a program" : kept.scene.file.c_str());
        for (const RodSpec& rods : kept.scene.rods)
            std::printf("  group '%s': %s\n", rods.name.c_str(),
                        rods.body ? "rigid bodies" : fmt::format("rods of {} elements", rods.shape.elements).c_str());
        std::printf("  newest of %zu checkpoints: step %lld of %lld, %s; t = %.6g s of %.6g s, dt = %.6g s\n",
                    kept.files, static_cast<long long>(kept.info.step), static_cast<long long>(steps),
                    share_done(kept.info.step, steps).c_str(), time, kept.scene.time.duration, kept.info.dt);
        std::printf("  digest %s\n", digest_text(kept.info.digest).c_str());
    }
    for (const auto& [prefix, what] :
         {std::pair{"trajectory_", "segments of frames"}, std::pair{"tips_", "segments of tips"}})
        if (const auto files = numbered_files(directory, prefix, ".h5"); !files.empty())
            std::printf("  %zu %s, from step %lld on\n", files.size(), what,
                        static_cast<long long>(files.front().number));
    std::error_code error;
    std::printf("  %s\n", fs::exists(directory + "/summary.json", error)
                              ? "the run ended or was stopped: summary.json"
                              : "no summary.json: the run is still active, or was killed");
}

} // namespace

int describe_command(const DescribeArguments& arguments, int& argc, char**& argv) {
    return alone([&] {
        const std::string& what = arguments.what;
        if (arguments.json) {
            const std::string text = description_json(what);
            if (text.empty()) throw InputError(fmt::format("there is no key or table '{}'{}", what, nearest_key(what)));
            std::printf("%s", text.c_str());
        } else if (what.empty()) {
            std::printf("%s", scene_reference().c_str());
        } else if (what.ends_with(".toml")) {
            std::printf("%s", scene_toml(read_scene(what), Keys::all).c_str());
        } else if (holds_results(what)) {
            std::printf("%s", scene_toml(kept_in(what, argc, argv).scene, Keys::all).c_str());
        } else if (std::error_code error; fs::is_directory(what, error)) {
            refuse_other_directory(what);
            std::printf("%s", scene_toml(read_scene((fs::path(what) / "scene.toml").string()), Keys::all).c_str());
        } else {
            const std::string text = describe_key(what);
            if (text.empty()) throw InputError(fmt::format("there is no key or table '{}'{}", what, nearest_key(what)));
            std::printf("%s", text.c_str());
        }
    });
}

int info_command(SceneArguments scene, std::string out, int& argc, char**& argv) {
    return alone([&] {
        std::printf("skein %s, built with %s\n", SKEIN_VERSION, SKEIN_COMPILER);
        std::printf("kernels for %s: %d lanes%s\n", std::string(level_name(widest_lanes())).c_str(), widest_lanes(),
                    std::getenv("SKEIN_LANES") ? " (SKEIN_LANES)" : "");
        std::printf("this process may use %d of %u cores\n", Threads::available_cores(),
                    std::thread::hardware_concurrency());
        std::fflush(stdout);
        if (scene.file.empty()) return;
        if (holds_results(scene.file)) return tell_results(scene.file, argc, argv);
        refuse_other_directory(scene.file);
        look_into_directory(scene, out);
        const SceneSpec spec = read_scene(scene.file, scene.overrides);
        if (out.empty()) out = default_out(scene.file);
        if (holds_results(out)) return tell_results(out, argc, argv);
        std::printf("%s: no checkpoint in %s\n", scene.file.c_str(), out.c_str());
    });
}

} // namespace skein
