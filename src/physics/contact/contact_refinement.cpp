#include "physics/scene_spec.hpp"

namespace skein {

void ContactTables::note_refinement(const SceneSpec& scene, std::vector<std::string>& notes) {
    if (scene.contact || !scene.walls.empty())
        notes.emplace_back(
            "laws of contacts and walls stay as they are, per pair of elements and per node: rods that lie against "
            "something along their length meet it harder with more elements");
}

} // namespace skein
