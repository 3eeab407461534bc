// Bringing rods to rest, with the cost measured.
#pragma once

#include "skein/core/index.hpp"
#include "support/core_seconds.hpp"
#include "support/scenes_for_tests.hpp"

#include <cmath>

namespace skein::test {

struct Cost {
    double element_steps = 0;
    double seconds = 0; ///< processor time of all threads
};

/// Advances all rods of a stage to step `until`, adding to `cost`.
inline void advance(Stage& stage, std::int64_t until, Cost& cost) {
    double elements = 0;
    for (const LocalRod& rod : stage.rods->local()) elements += nth(stage.groups, rod.group).elements();
    const auto steps = static_cast<double>(until - stage.clock.done());
    const double begin = core_seconds();
    stage.advance(until);
    cost.seconds += core_seconds() - begin;
    cost.element_steps += steps * elements;
}

/// One rod on its way to rest: damped at twice its lowest frequency `omega` (rad/s) for 40/omega, so that the slowest
/// motion shrinks by 41 e^-40 = 2e-16. Statics do not depend on density or damping.
inline SceneSpec coming_to_rest(const RodSpec& rod, double omega, std::vector<LoadSpec> loads) {
    SceneSpec scene;
    scene.time = {.duration = 40 / omega};
    scene.rods = {rod};
    scene.loads = std::move(loads);
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 2 * omega}}};
    return scene;
}

/// First frequency of a clamped slender rod of circular section, rad/s: 3.516 sqrt(EI/(rho A))/L^2.
inline double cantilever_frequency(const RodSpec& rod) {
    return 3.516 * 0.5 * rod.section.radius * std::sqrt(rod.material.youngs_modulus / rod.material.density) /
           (rod.shape.length * rod.shape.length);
}

} // namespace skein::test
