#include "rod/rod_profile.hpp"

#include "core/rotation.hpp"
#include "rod/law.hpp"
#include "rod/moving_ends.hpp"
#include "rod/rigid.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// Of a cell of rest length D around a node.
void add_cell(NodeProfile& at, const Vec3d& turn, double length, double bending_factor, const Vec3d& stiffness,
              const Vec3d& rest_curvature) {
    const Vec3d curvature = (1 / length) * turn, strain = curvature - rest_curvature;
    at.curvature = std::hypot(curvature.x, curvature.y);
    at.energy += 0.5 * length * bending_factor * dot(strain, scale(stiffness, strain));
}

} // namespace

void rod_profile(const RodGroup& group, std::span<const Slot<1>> state, double time, std::span<NodeProfile> out) {
    std::fill(out.begin(), out.end(), NodeProfile{});
    if (is_rigid(group)) return;
    const bool published = group.law() == Law::elastica; // which has no energy: what stands for it, as in the observables
    const auto factor = [&](double dilatation) {
        return with_energy_law(group.law(), [&]<class L>(L) { return L::bending_factor(1 / dilatation); });
    };
    const auto director = [&](std::size_t k) { return lane(state[k].director, 0); };
    const auto n = static_cast<std::size_t>(group.elements());
    std::vector<double> e(n), length(n + 1);
    for (std::size_t k = 0; k < n; ++k) {
        const ElementConstants& c = group.element[k];
        const Vec3d nu = c.inv_rest_length * (director(k) * (lane(state[k + 1].position, 0) - lane(state[k].position, 0)));
        e[k] = published ? norm(nu) : nu.z;
        const double sx = nu.x - c.rest_strain.x, sy = nu.y - c.rest_strain.y;
        const double shear = 0.5 / (published ? e[k] : 1) * (c.stiffness.x * sx * sx + c.stiffness.y * sy * sy);
        const double stretch = with_energy_law(group.law(), [&]<class L>(L) { return L::stretch_energy(c, e[k]); });
        for (const std::size_t node : {k, k + 1}) {
            out[node].strain += 0.5 * (e[k] - c.rest_stretch);
            out[node].energy += 0.5 * c.rest_length * (shear + stretch);
            length[node] += 0.5 * c.rest_length;
        }
    }
    for (std::size_t k = 0; k < group.voronoi.size(); ++k) {
        const VoronoiConstants& v = group.voronoi[k];
        const std::size_t next = (k + 1) % n;
        add_cell(out[k + 1], relative_rotation(director(next), director(k)), 1 / v.inv_length,
                 factor(v.share_before * e[k] + v.share_after * e[next]), v.stiffness, v.rest_curvature);
    }
    const ElementConstants &first = group.element[0], &last = group.element[n - 1];
    if (group.spec().start == EndKind::clamped)
        add_cell(out[0], relative_rotation(director(0), start_wall_frame(group, time)), 0.5 * first.rest_length, factor(e[0]),
                 first.bending, group.start_wall_rest_curvature);
    if (group.spec().end == EndKind::clamped)
        add_cell(out[n], relative_rotation(end_wall_frame(group, time), director(n - 1)), 0.5 * last.rest_length, factor(e[n - 1]),
                 last.bending, group.end_wall_rest_curvature);
    if (group.closed()) {
        out[n] = {out[0].strain + out[n].strain, out[n].curvature, out[0].energy + out[n].energy};
        out[0] = out[n];
        length[0] = length[n] = length[0] + length[n];
    } else {
        out[0].strain *= 2, out[n].strain *= 2;
    }
    for (std::size_t i = 0; i <= n; ++i) out[i].energy /= length[i];
}

} // namespace skein
