// Free, undamped rods in motion, whose energy should stay.
#pragma once

#include "support/scenes_for_tests.hpp"

namespace skein::test {

/// A bent, twisted, spinning rod of 20 elements; elliptic for the general top.
inline SceneSpec flying_rod(bool elliptic, double duration) {
    SceneSpec scene;
    RodSpec rod = simple_rod(20);
    rod.section = {.radius = 0.03};
    if (elliptic) rod.section = {.kind = SectionKind::elliptic, .radius = 0.04, .radius_2 = 0.02};
    rod.shape.start_curvature = Vec3d{1.5, 0.5, 1.0};
    rod.shape.velocity = {0.1, 0.2, -0.1};
    rod.shape.element_spin = {0.3, -0.2, 2.0};
    scene.rods = {rod};
    scene.time = {.duration = duration};
    return scene;
}

/// State at rest with nodes along a curve: d3 along the chords, d1 by parallel transport from `d1`.
inline std::vector<Slot<1>> along_curve(const std::vector<Vec3d>& node, Vec3d d1) {
    std::vector<Slot<1>> state(node.size());
    const auto unit = [](const Vec3d& a) { return (1 / norm(a)) * a; };
    Vec3d before{0, 0, 0};
    for (std::size_t k = 0; k < node.size(); ++k) {
        set_lane(state[k].position, 0, node[k]);
        set_lane(state[k].velocity, 0, Vec3d{0, 0, 0});
        set_lane(state[k].spin, 0, Vec3d{0, 0, 0});
        if (k + 1 == node.size()) {
            set_lane(state[k].director, 0, no_turn);
            break;
        }
        const Vec3d d3 = unit(node[k + 1] - node[k]);
        if (k > 0) { // the least turn that takes the tangent before to this one
            const Vec3d axis = cross(before, d3);
            d1 = d1 + cross(axis, d1) + (1 / (1 + dot(before, d3))) * cross(axis, cross(axis, d1));
        }
        d1 = unit(d1 - dot(d1, d3) * d3);
        set_lane(state[k].director, 0, quaternion({d1, cross(d3, d1), d3}));
        before = d3;
    }
    return state;
}

/// PyElastica's butterfly: a straight rod folded to a right angle at its middle and let go for 40 s. L 3 m, r 0.25 m,
/// 5000 kg/m^3, E 1e4 Pa, G = E/1.5.
inline SceneSpec butterfly(long n) {
    SceneSpec scene;
    RodSpec rod = simple_rod(n);
    rod.material = {.density = 5000, .youngs_modulus = 1e4, .shear_modulus = 1e4 / 1.5};
    rod.section = {.radius = 0.25};
    rod.shape.length = 3;
    scene.rods = {rod};
    scene.time = {.duration = 40};
    return scene;
}
inline void fold(Stage& butterfly) {
    const Shape& shape = butterfly.scene.rods[0].shape;
    const double dl = shape.length / static_cast<double>(shape.elements);
    std::vector<Vec3d> node{{0, 0, 0}};
    for (long k = 0; k < shape.elements; ++k)
        node.push_back(node.back() + (dl * std::sqrt(0.5)) * Vec3d{k < shape.elements / 2 ? 1.0 : -1.0, 0, 1});
    butterfly.rods->import_rod(0, along_curve(node, {0, 1, 0}));
}

} // namespace skein::test
