// A scene as plain data: what a TOML file or a C++ author says, before anything is decided about how to run it.
#pragma once

#include "contact/contact_spec.hpp"
#include "contact/wall.hpp"
#include "fluid/fluid_spec.hpp"
#include "formula/scope.hpp"
#include "immersion/immersion_spec.hpp"
#include "immersion/obstacle.hpp"
#include "io/fluid_output_spec.hpp"
#include "io/output_spec.hpp"
#include "io/start_spec.hpp"
#include "joints/joint_spec.hpp"
#include "loads/load_spec.hpp"
#include "skein/placement/assembly.hpp"
#include "skein/rod/rod_spec.hpp"
#include "time/time_spec.hpp"

#include <optional>
#include <string>
#include <vector>

namespace skein {

struct SceneSpec {
    std::string title;
    TimeSpec time;
    std::vector<RodSpec> rods;              ///< and bodies, behind them where a file says so
    std::vector<FormulaConstant> constants; ///< that formulas may name
    std::vector<FormulaTable> tables;
    std::vector<LoadSpec> loads;
    std::vector<DampingSpec> damping;
    std::optional<ContactSpec> contact; ///< absent: rods do not feel each other
    std::vector<ContactPair> contact_pairs;
    std::optional<FluidSpec> fluid;
    ImmersionSpec immersion;
    std::vector<Obstacle> obstacles; ///< in the fluid
    std::vector<Wall> walls;
    std::vector<AssemblySpec> assemblies;
    std::vector<JointSpec> joints;
    OutputSpec output;
    std::vector<FluidOutputSpec> fluid_outputs;
    StartSpec start;

    /// Whether bodies are in a fluid.
    bool has_immersed() const { return fluid && (!obstacles.empty() || !rods.empty()); }

    std::string file; ///< where the scene was read from; relative paths in it start there
};

} // namespace skein
