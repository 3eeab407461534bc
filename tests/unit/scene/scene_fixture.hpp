// What the tests of this folder share: a good scene, and the message of a bad one.
#pragma once

#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace skein {

inline const std::string test_data = SCENE_TEST_DATA;
inline const std::string good_scene = test_data + "/good/cilia.toml";

/// The good scene, and all that are shipped.
inline std::vector<std::string> all_scenes() {
    std::vector<std::string> files = {good_scene};
    for (const auto& entry : std::filesystem::recursive_directory_iterator(SHIPPED_SCENES))
        if (entry.path().extension() == ".toml") files.push_back(entry.path().string());
    return files;
}

/// What read_scene says to a scene; empty where it is content.
inline std::string refusal(const std::string& file, const std::vector<std::string>& overrides = {}) {
    try {
        read_scene(file, overrides);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

/// What check_scene says.
inline std::string refusal(const SceneSpec& scene) {
    try {
        check_scene(scene);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

} // namespace skein
