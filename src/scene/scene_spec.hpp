// A scene as plain data: what a TOML file or a C++ author says, before anything is decided about how to run it.
#pragma once

#include "io/output_spec.hpp"
#include "loads/load_spec.hpp"
#include "rod/rod_spec.hpp"
#include "time/time_spec.hpp"

#include <string>
#include <vector>

namespace skein {

struct SceneSpec {
    std::string title;
    TimeSpec time;
    std::vector<RodSpec> rods;
    std::vector<LoadSpec> loads;
    std::vector<DampingSpec> damping;
    OutputSpec output;

    std::string file; ///< where the scene was read from; relative paths in it start there
};

} // namespace skein
