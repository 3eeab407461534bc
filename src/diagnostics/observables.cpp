#include "diagnostics/observables.hpp"

#include "core/rotation.hpp"
#include "parallel/exact_sum.hpp"
#include "rod/law.hpp"
#include "rod/moving_ends.hpp"
#include "rod/rigid.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {

namespace {

double quadratic(const Vec3d& a, const Vec3d& diagonal) { return dot(a, scale(diagonal, a)); }

/// Bending (d1, d2) and twisting (d3) energy of a cell of length D: D/2 q times the law's factor on B.
void add_cell(RodEnergy& u, const Vec3d& phi, double length, double bending_factor, const Vec3d& stiffness,
              const Vec3d& rest_curvature) {
    const Vec3d strain = (1 / length) * phi - rest_curvature;
    const double weight = 0.5 * length * bending_factor;
    u.bend += weight * (stiffness.x * strain.x * strain.x + stiffness.y * strain.y * strain.y);
    u.twist += weight * stiffness.z * strain.z * strain.z;
}

/// Sums over rods, then extremes.
enum Sum {
    translation,
    rotation_,
    stretch,
    shear,
    bend,
    twist,
    momentum_x,
    momentum_y,
    momentum_z,
    mass_x,
    mass_y,
    mass_z,
    mass,
    sums
};
enum Extreme { speed, strain, turn, skew, extremes };

struct RodFigures {
    std::array<double, sums> sum{};
    std::array<double, extremes> extreme{};
};

RodFigures figures(const RodGroup& group, std::span<const Slot<1>> state, double time, std::int64_t index) {
    RodFigures f;
    const RodEnergy u = rod_energy(group, state, time, index);
    f.sum[translation] = u.translation;
    f.sum[rotation_] = u.rotation;
    f.sum[stretch] = u.stretch;
    f.sum[shear] = u.shear;
    f.sum[bend] = u.bend;
    f.sum[twist] = u.twist;
    for (std::size_t i = 0; i < state.size(); ++i) {
        const double m = group.node_mass[i];
        const Vec3d v = lane(state[i].velocity, 0), x = lane(state[i].position, 0);
        f.sum[momentum_x] += m * v.x;
        f.sum[momentum_y] += m * v.y;
        f.sum[momentum_z] += m * v.z;
        f.sum[mass_x] += m * x.x;
        f.sum[mass_y] += m * x.y;
        f.sum[mass_z] += m * x.z;
        f.sum[mass] += m;
        f.extreme[speed] = std::max(f.extreme[speed], norm(v));
    }
    for (std::size_t k = 0; k + 1 < state.size(); ++k) {
        const Quaterniond q = lane(state[k].director, 0);
        f.extreme[skew] = std::max(f.extreme[skew], std::abs(dot(q, q) - 1));
        if (is_rigid(group)) break;
        const double e =
            group.element[k].inv_rest_length * dot(third_director(q), lane(state[k + 1].position, 0) - lane(state[k].position, 0));
        f.extreme[strain] = std::max(f.extreme[strain], std::abs(e - group.element[k].rest_stretch));
    }
    for (std::size_t k = 0; k < group.voronoi.size(); ++k) {
        const std::size_t next = (k + 1) % group.element.size();
        f.extreme[turn] =
            std::max(f.extreme[turn], norm(relative_rotation(lane(state[next].director, 0), lane(state[k].director, 0))));
    }
    return f;
}

} // namespace

RodEnergy rod_energy(const RodGroup& group, std::span<const Slot<1>> state, double time, std::int64_t index) {
    if (is_rigid(group)) {
        const RigidEnergy u = rigid_energy(group, state);
        return {.translation = u.translation, .rotation = u.rotation};
    }
    // The published law has no energy: what stands for it are the integrals of its axial force, shear force and moment, each alone.
    const bool published = group.law() == Law::elastica;
    const auto factor = [&](double dilatation) {
        return with_energy_law(group.law(), [&]<class L>(L) { return L::bending_factor(1 / dilatation); });
    };
    RodEnergy u;
    for (std::size_t i = 0; i < state.size(); ++i) {
        const Vec3d v = lane(state[i].velocity, 0);
        u.translation += 0.5 * group.node_mass[i] * dot(v, v);
    }
    const auto n = static_cast<std::size_t>(group.elements());
    std::vector<double> e(n);
    for (std::size_t k = 0; k < n; ++k) {
        const ElementConstants& c = group.element[k];
        const Quaterniond q = lane(state[k].director, 0);
        const Vec3d nu = c.inv_rest_length * (q * (lane(state[k + 1].position, 0) - lane(state[k].position, 0)));
        e[k] = published ? norm(nu) : nu.z;
        const double per_section = published ? 1 / e[k] : 1;
        const double sx = nu.x - c.rest_strain.x, sy = nu.y - c.rest_strain.y;
        u.rotation += 0.5 * per_section * quadratic(lane(state[k].spin, 0), c.inertia);
        u.shear += 0.5 * per_section * c.rest_length * (c.stiffness.x * sx * sx + c.stiffness.y * sy * sy);
        u.stretch += c.rest_length * with_energy_law(group.law(), [&]<class L>(L) { return L::stretch_energy(c, e[k]); });
    }
    for (std::size_t k = 0; k < group.voronoi.size(); ++k) {
        const VoronoiConstants& v = group.voronoi[k];
        const std::size_t next = (k + 1) % n;
        add_cell(u, relative_rotation(lane(state[next].director, 0), lane(state[k].director, 0)), 1 / v.inv_length,
                 factor(v.share_before * e[k] + v.share_after * e[next]), v.stiffness, v.rest_curvature);
    }
    if (group.spec().start == EndKind::clamped)
        add_cell(u, relative_rotation(lane(state[0].director, 0), start_wall_frame(group, index, time)),
                 0.5 * group.element[0].rest_length, factor(e[0]), group.element[0].bending, group.start_wall_rest_curvature);
    if (group.spec().end == EndKind::clamped)
        add_cell(u, relative_rotation(end_wall_frame(group, index, time), lane(state[n - 1].director, 0)),
                 0.5 * group.element[n - 1].rest_length, factor(e[n - 1]), group.element[n - 1].bending,
                 group.end_wall_rest_curvature);
    return u;
}

std::vector<std::string> observable_names(const ObservableSets& sets) {
    std::vector<std::string> names = {"kinetic_translation[J]",
                                      "kinetic_rotation[J]",
                                      "elastic_stretch[J]",
                                      "elastic_shear[J]",
                                      "elastic_bend[J]",
                                      "elastic_twist[J]",
                                      "momentum_x[kg m/s]",
                                      "momentum_y[kg m/s]",
                                      "momentum_z[kg m/s]",
                                      "centre_x[m]",
                                      "centre_y[m]",
                                      "centre_z[m]",
                                      "max_speed[m/s]",
                                      "max_axial_strain[-]",
                                      "max_turn_per_cell[rad]",
                                      "max_director_defect[-]"};
    for (std::string& name : extra_names(sets)) names.push_back(std::move(name));
    return names;
}

double observed_energy(std::span<const double> observed) {
    const auto energies = observed.first(observed_energies);
    return std::accumulate(energies.begin(), energies.end(), 0.0);
}

std::vector<double> observe(const Communicator& comm, const Threads& threads, std::span<const RodGroup> groups, const Rods& rods,
                            double time, double lag, const ObservableSets& sets) {
    const auto local = rods.local();
    std::vector<RodFigures> all(local.size());
    std::vector<ExtraFigures> extra(sets.any() ? local.size() : 0);
    std::vector<std::vector<Slot<1>>> copies(static_cast<std::size_t>(threads.count()));
    threads.for_each(local.size(), [&](std::size_t i, int thread) {
        const RodGroup& group = groups[static_cast<std::size_t>(local[i].group)];
        auto& copy = copies[static_cast<std::size_t>(thread)];
        copy.resize(static_cast<std::size_t>(group.slots()));
        rods.export_rod(i, copy);
        synchronise(group, copy, lag);
        with_rod(group, local[i].index, [&](const RodGroup& own) {
            all[i] = figures(own, copy, time, local[i].index);
            if (sets.any()) extra[i] = extra_figures(own, copy, sets);
        });
    });

    std::vector<std::vector<double>> columns(sums, std::vector<double>(all.size()));
    std::array<double, extremes> extreme{};
    for (std::size_t i = 0; i < all.size(); ++i) {
        for (std::size_t s = 0; s < sums; ++s) columns[s][i] = all[i].sum[s];
        for (std::size_t x = 0; x < extremes; ++x) extreme[x] = std::max(extreme[x], all[i].extreme[x]);
    }
    std::vector<double> values = exact_sums(comm, columns);
    comm.max(extreme);
    for (int axis = 0; axis < 3; ++axis) values[mass_x + axis] /= values[mass];
    values.resize(mass);
    values.insert(values.end(), extreme.begin(), extreme.end());
    if (sets.any())
        for (const double value : extra_values(comm, extra, sets)) values.push_back(value);
    return values;
}

} // namespace skein
