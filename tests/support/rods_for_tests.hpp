// Rods that tests are made of: small specs, random states, one step at a chosen width.
#pragma once

#include "core/rotation.hpp"
#include "skein/core/index.hpp"
#include "skein/rod/rod_group.hpp"
#include "skein/tiles/tile.hpp"

#include <iterator>
#include <random>
#include <string>
#include <vector>

namespace skein::test {

/// Laws that have an energy: all but the published one.
inline std::vector<Law> energy_laws() {
    std::vector<Law> laws;
    for (std::size_t i = 0; i < std::size(law_names); ++i)
        if (static_cast<Law>(i) != Law::elastica) laws.push_back(static_cast<Law>(i));
    return laws;
}
inline std::string name_of(Law law) { return std::string(nth(law_names, law)); }

inline RodSpec simple_rod(long elements = 8) {
    RodSpec spec;
    spec.name = "rod";
    spec.material = {.density = 1000, .youngs_modulus = 1e6};
    spec.section = {.radius = 0.02};
    spec.shape = {.length = 1, .elements = elements};
    return spec;
}

/// Length, density and Young's modulus 1, clamped at the start.
inline RodSpec clamped_unit_rod(long elements, double radius) {
    RodSpec spec;
    spec.name = "rod";
    spec.material = {.density = 1, .youngs_modulus = 1};
    spec.section = {.radius = radius};
    spec.shape = {.length = 1, .elements = elements};
    spec.start = EndKind::clamped;
    return spec;
}

/// A capsule from the origin along d3; without length a ball about the origin.
inline RodSpec rigid_body(double length, double radius) {
    RodSpec spec;
    spec.name = "body";
    spec.material = {.density = 1000};
    spec.body.emplace();
    if (length > 0) spec.body->capsules = {{{0, 0, 0}}, {{0, 0, length}}, {radius}};
    else spec.body->spheres.radii = {radius};
    return spec;
}

/// A box about the origin, with edges rounded by 5 mm.
inline RodSpec box_body(const Vec3d& size) {
    RodSpec spec = rigid_body(0, 0.1);
    spec.body->spheres = {};
    spec.body->boxes = {{}, {size}, {0.005}};
    return spec;
}

/// A body of three parts, none of whose principal axes is one of theirs.
inline RodSpec crooked_body() {
    RodSpec spec = rigid_body(0, 0.03);
    spec.body->spheres.centres = {{0.05, -0.02, 0.01}};
    spec.body->capsules = {{{0, 0, 0}, {0.02, 0.01, 0}}, {{0.08, 0.03, 0.02}, {-0.03, 0.05, 0.06}}, {0.01, 0.015}};
    return spec;
}

/// Everything at once: elliptic, tapered, curved and strained at rest, with elements of unequal lengths.
inline RodSpec crooked_rod(long elements = 8) {
    RodSpec spec = simple_rod(elements);
    spec.section = {.kind = SectionKind::elliptic, .radius = 0.03, .radius_2 = 0.02, .taper = 0.5};
    spec.shape.rest_curvature = {0.7, -1.1, 0.4};
    spec.shape.rest_strain = {0.02, -0.01, 0.03};
    for (long k = 0; k < elements; ++k)
        spec.shape.length_profile.push_back(1 + 0.3 * static_cast<double>((7 * k) % 5) / 4);
    return spec;
}

/// Start state of rod 0, each node shifted and each frame turned at random, moving at random rates.
inline std::vector<Slot<1>> shaken_state(const RodGroup& group, double shift, double turn, double speed,
                                         unsigned seed = 1) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const auto vector = [&](double size) {
        return Vec3d{size * normal(random), size * normal(random), size * normal(random)};
    };
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    group.start_state(0, state);
    for (std::size_t k = 0; k < state.size(); ++k) {
        set_lane(state[k].position, 0, lane(state[k].position, 0) + vector(shift));
        set_lane(state[k].velocity, 0, vector(speed));
        if (k == group.element.size()) break;
        set_lane(state[k].director, 0, rotation(vector(turn)) * lane(state[k].director, 0));
        set_lane(state[k].spin, 0, vector(speed / group.element[k].rest_length));
    }
    return state;
}

struct Momenta {
    Vec3d linear{0, 0, 0}, angular{0, 0, 0}; ///< kg m/s; kg m^2/s about the origin, lab
};
inline Momenta momenta(const RodGroup& group, const std::vector<Slot<1>>& state) {
    Momenta sum;
    for (std::size_t i = 0; i < state.size(); ++i) {
        const Vec3d p = group.node_mass[i] * lane(state[i].velocity, 0);
        sum.linear += p;
        sum.angular += cross(lane(state[i].position, 0), p);
        if (i < group.element.size())
            sum.angular +=
                transpose_times(lane(state[i].director, 0), scale(group.element[i].inertia, lane(state[i].spin, 0)));
    }
    return sum;
}

using skein::tile_of;

} // namespace skein::test
