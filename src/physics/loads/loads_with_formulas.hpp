// Loads of a scene, with their formulas read.
#pragma once

#include "physics/scene_spec.hpp"

#include <vector>

namespace skein {

/// Loads of the scene, in its order.
inline std::vector<Load> loads_with_formulas(const SceneSpec& scene) {
    const FormulaScope names = names_for_formulas(scene);
    std::vector<Load> loads;
    for (const LoadSpec& spec : scene.loads) loads.emplace_back(spec.load).use(names);
    return loads;
}

} // namespace skein
