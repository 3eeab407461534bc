// The tables of every scene, whatever its physics.
#pragma once

#include "formula/scope.hpp"
#include "io/output_spec.hpp"
#include "io/start_spec.hpp"
#include "skein/rod/rod_spec.hpp"
#include "time/stage_spec.hpp"
#include "time/time_spec.hpp"

#include <string>
#include <vector>

namespace skein {

struct CoreTables {
    std::string title;
    TimeSpec time;
    std::vector<RodSpec> rods;              ///< and bodies, after them in files
    std::vector<FormulaConstant> constants; ///< names for formulas
    std::vector<FormulaTable> tables;
    std::vector<StageSpec> stages; ///< one after the other; none: the scene is the same throughout
    double stage_begin = 0;        ///< s: when the present stage has begun
    TimeSpan stage_lasts{};        ///< surely: without what depends on conditions that end stages
    OutputSpec output;
    StartSpec start;
    std::string file; ///< origin of the scene; relative paths in it start there
};

/// Names that formulas of a scene may hold.
inline FormulaScope names_for_formulas(const CoreTables& scene) {
    FormulaScope names{scene.constants, scene.tables, scene.time.duration, scene.stage_lasts};
    if (!scene.stages.empty()) names.constants.push_back({stage_begin_name, scene.stage_begin, "s"});
    return names;
}

} // namespace skein
