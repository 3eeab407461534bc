#include "options.hpp"

#include "document.hpp"

#include <CLI/CLI.hpp>

#include <map>
#include <string>

namespace skein {

namespace {

const std::map<std::string, Mapping> mappings = {
    {"auto", Mapping::automatic}, {"across", Mapping::across}, {"along", Mapping::along}};
const std::map<std::string, ProgressStyle> progress_styles = {
    {"auto", ProgressStyle::automatic}, {"bar", ProgressStyle::bar}, {"lines", ProgressStyle::lines}};

} // namespace

void add_overrides(CLI::App& command, SceneArguments& scene) {
    command.add_option("--set", scene.overrides, "override a key, e.g. --set time.duration=10 (may be repeated)")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
}

void add_json(CLI::App& command, bool& json, const char* text) {
    command.add_flag_callback(
        "--json",
        [&json] {
            json = true;
            keep_standard_output_for_document();
        },
        text);
}

void add_scene_options(CLI::App& command, SceneArguments& scene) {
    command.add_option("SCENE", scene.file, "scene file (TOML), or a directory that a branch began in")->required();
    add_overrides(command, scene);
}

void add_progress(CLI::App& command, ProgressStyle& style) {
    command
        .add_option("--progress", style,
                    "auto: one line rewritten on a terminal, lines in logs and under MPI launchers")
        ->transform(CLI::CheckedTransformer(progress_styles))
        ->option_text("{auto,bar,lines}=auto");
}
void add_mapping(CLI::App& command, Mapping& mapping) {
    command
        .add_option("--mapping", mapping,
                    "of rods onto lanes: one each, or cut and side by side with others; the same bits")
        ->transform(CLI::CheckedTransformer(mappings))
        ->option_text("{auto,across,along}=auto");
}

void add_lanes(CLI::App& command, int& lanes) {
    command
        .add_option(
            "--lanes", lanes,
            "rods side by side in SIMD registers, which chooses the kernels' instructions: x86-64 for 2, x86-64-v3 for "
            "1 and 4, x86-64-v4 for 8; default: the most that this processor has, fewer for few rods; the same bits")
        ->check(CLI::IsMember({1, 2, 4, 8}));
}

void add_threads(CLI::App& command, int& threads) {
    command.add_option("-t,--threads", threads, "threads per rank; default: the cores this rank may use")
        ->check(CLI::PositiveNumber);
}

} // namespace skein
