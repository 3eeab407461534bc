// Options that several commands have.
#pragma once

#include "commands.hpp"

namespace CLI {
class App;
}

namespace skein {

void add_overrides(CLI::App& command, SceneArguments& scene);
/// `text`: what the document holds.
void add_json(CLI::App& command, bool& json, const char* text);
void add_scene_options(CLI::App& command, SceneArguments& scene);
void add_progress(CLI::App& command, ProgressStyle& style);
void add_mapping(CLI::App& command, Mapping& mapping);
void add_lanes(CLI::App& command, int& lanes);
void add_threads(CLI::App& command, int& threads);

} // namespace skein
