#include "scene/scene_file.hpp"

#include "core/error.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_override.hpp"
#include "scene/scene_reader.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include <fmt/format.h>

namespace skein {

namespace {

std::string read_text(const std::string& file) {
    if (!std::filesystem::exists(file)) throw InputError(fmt::format("{}: there is no such file", file));
    if (!std::filesystem::is_regular_file(file)) throw InputError(fmt::format("{}: not a file", file));
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError(fmt::format("{}: cannot be opened for reading", file));
    return {std::istreambuf_iterator<char>(in), {}};
}

using Places = std::map<std::string, Place>;

/// The place of every key, table and list item of a scene, by its path.
void collect_places(const TomlValue& value, const std::string& path, Places& places) {
    const auto child = [&](const std::string& name) { return path.empty() ? name : path + "." + name; };
    if (const auto* table = value.as<TomlTable>()) {
        for (const TomlEntry& entry : *table) {
            places[child(entry.key)] = entry.place;
            collect_places(entry.value, child(entry.key), places);
        }
    }
    if (const auto* list = value.as<TomlArray>()) {
        for (std::size_t i = 0; i < list->size(); ++i) {
            places[child(std::to_string(i))] = (*list)[i].place;
            collect_places((*list)[i], child(std::to_string(i)), places);
        }
    }
}

/// The place of a path, or of the innermost table around it that the scene has.
Place nearest_place(const Places& places, std::string path, const Place& otherwise) {
    while (!path.empty()) {
        if (const auto at = places.find(path); at != places.end()) return at->second;
        const std::size_t dot = path.rfind('.');
        path.erase(dot == std::string::npos ? 0 : dot);
    }
    return otherwise;
}

void add_contradictions(const SceneSpec& scene, const TomlValue& root, Problems& problems) {
    Places places;
    collect_places(root, "", places);
    std::set<std::string> given;
    for (const auto& [path, place] : places) given.insert(path);
    for (const auto& [path, message] : contradictions(scene, given))
        problems.add(nearest_place(places, path, {root.place.text, 1, 1, 1}), message);
}

} // namespace

SceneSpec read_scene(const std::string& file, const std::vector<std::string>& overrides) {
    const std::string text = read_text(file);
    TomlValue root = parse_toml(text, source_text(file, text));
    for (const std::string& override : overrides) apply_override(root, override);
    Problems problems;
    SceneSpec scene = read_tables(root, problems);
    scene.file = file;
    // A value that could not be read is still the default, which would only contradict the others.
    if (problems.empty()) add_contradictions(scene, root, problems);
    problems.raise();
    return scene;
}

} // namespace skein
