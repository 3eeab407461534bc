// A box of fluid around the rods of a scene.
#pragma once

#include "physics/scene_spec.hpp"

#include <string>

namespace skein {

/// The fluid of a scene, which has one; where margins stand in place of its box, with the box that they make.
FluidSpec fitted_fluid(const SceneSpec& scene);

/// Why no box can be fitted to the rods of a scene; empty: one can.
std::string unfitted(const SceneSpec& scene);

} // namespace skein
