// Rods that tests are made of: small specs, random states, one step at a chosen width.
#pragma once

#include "core/rotation.hpp"
#include "rod/rod_group.hpp"
#include "rod/tile.hpp"

#include <random>
#include <vector>

namespace skein::test {

inline RodSpec simple_rod(long elements = 8) {
    RodSpec spec;
    spec.name = "rod";
    spec.material = {.density = 1000, .youngs_modulus = 1e6};
    spec.section = {.radius = 0.02};
    spec.shape = {.length = 1, .elements = elements};
    return spec;
}

/// Everything at once: elliptic, tapered, curved and strained at rest, with elements of unequal lengths.
inline RodSpec crooked_rod(long elements = 8) {
    RodSpec spec = simple_rod(elements);
    spec.section = {.kind = SectionKind::elliptic, .radius = 0.03, .radius_2 = 0.02, .taper = 0.5};
    spec.shape.rest_curvature = {0.7, -1.1, 0.4};
    spec.shape.rest_strain = {0.02, -0.01, 0.03};
    for (long k = 0; k < elements; ++k) spec.shape.length_profile.push_back(1 + 0.3 * static_cast<double>((7 * k) % 5) / 4);
    return spec;
}

/// Start state of rod 0, each node shifted and each frame turned at random, moving at random rates.
inline std::vector<Slot<1>> shaken_state(const RodGroup& group, double shift, double turn, double speed, unsigned seed = 1) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const auto vector = [&](double size) { return Vec3d{size * normal(random), size * normal(random), size * normal(random)}; };
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    group.start_state(0, state);
    for (std::size_t k = 0; k < state.size(); ++k) {
        set_lane(state[k].position, 0, lane(state[k].position, 0) + vector(shift));
        set_lane(state[k].velocity, 0, vector(speed));
        if (k + 1 == state.size()) break;
        set_lane(state[k].director, 0, rotation(vector(turn)) * lane(state[k].director, 0));
        set_lane(state[k].spin, 0, vector(speed / group.element[k].rest_length));
    }
    return state;
}

inline RodTile<1> tile_of(const RodGroup& group, std::vector<Slot<1>>& state) {
    return {state.data(), group.element.data(), group.voronoi.data(), &group, group.elements(), 0, {0}, 1};
}

} // namespace skein::test
