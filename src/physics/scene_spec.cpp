#include "physics/scene_spec.hpp"

namespace skein {

std::string path_of_group(const CoreTables& scene, std::size_t group) {
    const bool body = scene.rods[group].body.has_value();
    std::size_t number = 0;
    for (std::size_t i = 0; i < group; ++i) number += scene.rods[i].body.has_value() == body;
    return (body ? "bodies." : "rods.") + std::to_string(number);
}

RodSpec default_body() {
    RodSpec spec;
    spec.body.emplace();
    return spec;
}

} // namespace skein
