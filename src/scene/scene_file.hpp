// Scene files: TOML -> SceneSpec. Every key is known from the spec structs' fields(); anything else is an error with
// file, line, column, what was expected and the nearest valid key. On the way: text -> tree (scene_toml) -> overrides
// (scene_override)
// -> structs (scene_reader) -> contradictions (scene_check).
#pragma once

#include "physics/scene_spec.hpp"

#include <string>
#include <vector>

namespace skein {

/// Reads and checks a scene. `overrides` are "path=value" pairs from --set, e.g. "time.duration=10",
/// "rods.cilia.shape.elements=50", "rods.0.section.radius=0.1", with values in TOML syntax; text may go without quotes.
/// Throws InputError with all that is wrong (up to ten messages), each as "file:line:column: message" and the line with
/// carets below it, or as "--set path=value: message". Contradictions are looked for once every key could be read.
SceneSpec read_scene(const std::string& file, const std::vector<std::string>& overrides = {});

/// Two halves of read_scene, so that one rank reads the file and all have its text. `file` is for messages and relative
/// paths.
std::string read_scene_text(const std::string& file);
SceneSpec parse_scene(const std::string& file, const std::string& text, const std::vector<std::string>& overrides = {});

/// Checks that need more than one key: names unique, groups that loads name exist, profile lengths, keys without use,
/// ... For scenes made in C++; read_scene does the same and knows the lines. Throws InputError with all that is wrong,
/// one per line.
void check_scene(const SceneSpec& scene);

/// The scene with every key and default spelled out, as one JSON object with sorted, indented keys: what a checkpoint
/// keeps. `physics_only` leaves title and outputs out, which may change on resume.
std::string scene_json(const SceneSpec& scene, bool physics_only);

/// Keys that a scene is written with: those that it gives, or all, with defaults as comments.
enum class Keys { given, all };

/// The scene as TOML, which reads back as the same scene, to the last bit of its numbers. With all keys also their
/// units and meanings.
std::string scene_toml(const SceneSpec& scene, Keys which);

/// The reference page of all keys (docs/scene.md), in Markdown.
std::string scene_reference();

/// Lines of text for one key or the keys of a table, e.g. "rods.shape.length" or "rods.material"; empty where
/// there is none.
std::string describe_key(const std::string& path);

} // namespace skein
