// What is known of the build, of a scene, of a run's results, and of the keys of scenes.
#include "commands.hpp"
#include "document.hpp"

#include "core/level.hpp"
#include "io/checkpoint.hpp"
#include "io/disk.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "scene/scene_description.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_rebuild.hpp"
#include "simulation/machine.hpp"
#include "simulation/progress.hpp"
#include "simulation/summary.hpp"
#include "simulation/warnings.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <thread>

namespace skein {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

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
            print_warning(error.what());
        }
    }
    return {};
}

Json json_of_results(const std::string& directory, int& argc, char**& argv) {
    Json json = {{"directory", directory}};
    std::error_code error;
    json["ended"] = fs::exists(directory + "/summary.json", error);
    for (const auto& [key, prefix] :
         {std::pair{"checkpoints", "checkpoint_"}, std::pair{"frames", "trajectory_"}, std::pair{"tips", "tips_"}}) {
        const auto files = numbered_files(directory, prefix, ".h5");
        json[key] = {{"files", files.size()}};
        if (!files.empty()) json[key]["first_step"] = files.front().number;
    }
    if (json["checkpoints"]["files"] == 0) return json;
    const Kept kept = kept_in(directory, argc, argv);
    json["title"] = kept.scene.title;
    json["scene"] = kept.scene.file;
    json["groups"] = Json::array();
    for (const RodSpec& rods : kept.scene.rods)
        json["groups"].push_back({{"name", rods.name}, {"elements", rods.body ? 0 : rods.shape.elements}});
    json["step"] = kept.info.step;
    json["steps"] =
        static_cast<std::int64_t>(std::llround((kept.scene.time.duration - kept.info.shift) / kept.info.dt));
    json["time_s"] = kept.info.shift + static_cast<double>(kept.info.step) * kept.info.dt;
    json["duration_s"] = kept.scene.time.duration;
    json["dt_s"] = kept.info.dt;
    json["digest"] = digest_text(kept.info.digest);
    return json;
}

std::string text_of_results(const Json& run) {
    std::string text = fmt::format("{}: results of a run\n", run["directory"].get<std::string>());
    if (!run.contains("step")) {
        text += "  no checkpoint yet: the same command begins at the start\n";
    } else {
        const auto file = run["scene"].get<std::string>();
        text +=
            fmt::format("  scene '{}', from {}\n", run["title"].get<std::string>(), file.empty() ? "a program" : file);
        for (const Json& group : run["groups"]) {
            const auto elements = group["elements"].get<long>();
            text += fmt::format("  group '{}': {}\n", group["name"].get<std::string>(),
                                elements ? fmt::format("rods of {} elements", elements) : "rigid bodies");
        }
        const auto step = run["step"].get<std::int64_t>(), steps = run["steps"].get<std::int64_t>();
        text += fmt::format(
            "  newest of {} checkpoints: step {} of {}, {}; t = {:.6g} s of {:.6g} s, dt = {:.6g} s\n  digest {}\n",
            run["checkpoints"]["files"].get<std::size_t>(), step, steps, share_done(step, steps),
            run["time_s"].get<double>(), run["duration_s"].get<double>(), run["dt_s"].get<double>(),
            run["digest"].get<std::string>());
    }
    for (const auto& [key, what] : {std::pair{"frames", "segments of frames"}, std::pair{"tips", "segments of tips"}})
        if (run[key].contains("first_step"))
            text += fmt::format("  {} {}, from step {} on\n", run[key]["files"].get<std::size_t>(), what,
                                run[key]["first_step"].get<std::int64_t>());
    return text + (run["ended"].get<bool>() ? "  the run ended or was stopped: summary.json\n"
                                            : "  no summary.json: the run is still active, or was killed\n");
}

} // namespace

int describe_command(const DescribeArguments& arguments, int& argc, char**& argv) {
    return alone([&] {
        const std::string& what = arguments.what;
        if (arguments.json) {
            const std::string text = description_json(what);
            if (text.empty()) throw InputError(fmt::format("there is no key or table '{}'{}", what, nearest_key(what)));
            print_result(text);
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

int info_command(InfoArguments arguments, int& argc, char**& argv) {
    return alone([&] {
        auto& [scene, out, as_json] = arguments;
        const bool chosen = std::getenv("SKEIN_LANES");
        const int lanes = lanes_for(0);
        Json json = {{"version", SKEIN_VERSION},
                     {"compiler", SKEIN_COMPILER},
                     {"level", level_name(lanes)},
                     {"lanes", lanes},
                     {"available_cores", Threads::available_cores()},
                     {"cores", std::thread::hardware_concurrency()}};
        std::string text =
            fmt::format("skein {}, built with {}\nkernels for {}: {} lanes{}\nthis process may use {} of "
                        "{} cores\n",
                        SKEIN_VERSION, SKEIN_COMPILER, level_name(lanes), lanes, chosen ? " (SKEIN_LANES)" : "",
                        Threads::available_cores(), std::thread::hardware_concurrency());
        std::string results = scene.file;
        if (!scene.file.empty() && !holds_results(scene.file)) {
            refuse_other_directory(scene.file);
            look_into_directory(scene, out);
            const SceneSpec spec = read_scene(scene.file, scene.overrides);
            results = out.empty() ? default_out(scene.file) : out;
        }
        if (holds_results(results)) {
            json["run"] = json_of_results(results, argc, argv);
            text += text_of_results(json["run"]);
        } else if (!results.empty()) {
            text += fmt::format("{}: no checkpoint in {}\n", scene.file, results);
        }
        if (as_json) print_document(json);
        else print_result(text);
    });
}

} // namespace skein
