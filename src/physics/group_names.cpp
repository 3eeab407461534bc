#include "physics/group_names.hpp"

#include "core/nearest.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace skein {

bool good_name(const std::string& name) {
    return !name.empty() && std::all_of(name.begin(), name.end(),
                                        [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; });
}

const RodSpec* group_named(const SceneSpec& scene, const std::string& name, Objections& objections,
                           const std::string& key) {
    std::vector<std::string_view> known;
    for (const RodSpec& rods : scene.rods) {
        if (rods.name == name) return &rods;
        known.push_back(rods.name);
    }
    objections.add(key,
                   fmt::format("there is no group of rods '{}'{}", name, suggestion(name, known, "the groups are")));
    return nullptr;
}

bool names_group(const std::vector<std::string>& names, const std::string& group) {
    return names.empty() || std::find(names.begin(), names.end(), group) != names.end();
}

std::vector<const RodSpec*> acted_on(const SceneSpec& scene, const std::vector<std::string>& names,
                                     Objections& objections) {
    std::vector<const RodSpec*> groups;
    if (names.empty()) {
        for (const RodSpec& rods : scene.rods) groups.push_back(&rods);
        if (objections.given("rods")) objections.add("rods", "'rods' names no group; leave it out to mean all");
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        const std::string item = fmt::format("rods.{}", i);
        const RodSpec* group = group_named(scene, names[i], objections, item);
        if (!group) continue;
        if (std::find(names.begin(), names.begin() + static_cast<long>(i), names[i]) !=
            names.begin() + static_cast<long>(i))
            objections.add(item, fmt::format("the group '{}' is named twice", names[i]));
        else groups.push_back(group);
    }
    return groups;
}

} // namespace skein
