// PyElastica's thick clamped rod under a small transverse force on its tip, coming to rest. The deflection is 2.3e-4
// lengths, so the linear line holds to (w/L)^2 = 5e-8. G = E/100 puts the tension limit at e_c = 1.0097 (theory.md
// (15)); this rod does not stretch.
#pragma once

#include "loads/end_force.hpp"
#include "support/relaxation.hpp"
#include "support/timoshenko_beam.hpp"

namespace skein::test::timoshenko_cantilever {

constexpr TimoshenkoBeam beam{3, 0.25, 5000, 1e6, 1e4};
constexpr double force = 0.15; ///< N

inline SceneSpec scene(long n) {
    const RodSpec rod = clamped_rod(beam, n);
    const double omega = 0.7 * cantilever_frequency(rod); // shear makes it slower
    return coming_to_rest(rod, omega, {{.load = EndForce{.end = {force, 0, 0}}}});
}

} // namespace skein::test::timoshenko_cantilever
