#include "physics/assemblies.hpp"

#include "skein/core/index.hpp"

#include <algorithm>

namespace skein {

int assembly_named(const SceneSpec& scene, const std::string& assembly) {
    for (std::size_t a = 0; a < scene.assemblies.size(); ++a)
        if (scene.assemblies[a].name == assembly) return static_cast<int>(a);
    return -1;
}

std::vector<int> assembly_of_groups(const SceneSpec& scene) {
    std::vector<int> assembly;
    for (const RodSpec& rods : scene.rods) assembly.push_back(assembly_named(scene, rods.assembly));
    // Groups of no assembly that joints connect, by one or more, are one.
    const auto find = [&](const std::string& name) {
        for (std::size_t g = 0; g < scene.rods.size(); ++g)
            if (scene.rods[g].name == name) return g;
        return scene.rods.size();
    };
    int next = static_cast<int>(scene.assemblies.size());
    for (const JointSpec& joint : scene.joints) {
        if (joint.between.size() != 2) continue;
        const std::size_t a = find(joint.between[0]), b = joint.to_world() ? a : find(joint.between[1]);
        if (a == scene.rods.size() || b == scene.rods.size()) continue;
        const int of_a = assembly[a], of_b = assembly[b];
        if (of_a < 0 && of_b < 0) assembly[a] = assembly[b] = next++;
        else if (a == b) continue;
        else if (of_a < 0) assembly[a] = of_b;
        else if (of_b < 0) assembly[b] = of_a;
        else std::replace(assembly.begin(), assembly.end(), std::max(of_a, of_b), std::min(of_a, of_b));
    }
    // Numbers without gaps.
    std::vector<int> used;
    for (int& number : assembly) {
        if (number < static_cast<int>(scene.assemblies.size())) continue;
        const auto at = std::find(used.begin(), used.end(), number);
        const int place = static_cast<int>(scene.assemblies.size()) + static_cast<int>(at - used.begin());
        if (at == used.end()) used.push_back(number);
        number = place;
    }
    return assembly;
}

std::string assembly_name(const SceneSpec& scene, int assembly) {
    if (assembly < static_cast<int>(scene.assemblies.size())) return nth(scene.assemblies, assembly).name;
    std::string name;
    const std::vector<int> of_group = assembly_of_groups(scene);
    for (std::size_t g = 0; g < of_group.size(); ++g)
        if (of_group[g] == assembly) name += (name.empty() ? "" : " + ") + scene.rods[g].name;
    return name;
}

} // namespace skein
