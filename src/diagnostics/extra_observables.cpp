#include "diagnostics/extra_observables.hpp"

#include "core/rotation.hpp"
#include "diagnostics/knots.hpp"
#include "parallel/exact_sum.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

void add_angular_momentum(ExtraFigures& f, const RodGroup& group, std::span<const Slot<1>> state) {
    Vec3d sum{0, 0, 0};
    for (std::size_t i = 0; i < state.size(); ++i)
        sum += group.node_mass[i] * cross(lane(state[i].position, 0), lane(state[i].velocity, 0));
    for (std::size_t k = 0; k < group.element.size(); ++k)
        sum += transpose_times(lane(state[k].director, 0), scale(group.element[k].inertia, lane(state[k].spin, 0)));
    f.sum[ExtraFigures::angular_x] = sum.x;
    f.sum[ExtraFigures::angular_y] = sum.y;
    f.sum[ExtraFigures::angular_z] = sum.z;
}

void add_curvature(ExtraFigures& f, const RodGroup& group, std::span<const Slot<1>> state) {
    for (std::size_t k = 0; k < group.voronoi.size(); ++k) {
        const double inv_length = group.voronoi[k].inv_length / cell_weight(group, k + 1);
        const Vec3d phi = lane(relative_rotation(state[(k + 1) % group.element.size()].director, state[k].director), 0);
        const double bend = std::hypot(phi.x, phi.y);
        f.sum[ExtraFigures::bend_length] += bend;
        f.sum[ExtraFigures::twist_length] += phi.z;
        f.sum[ExtraFigures::cell_length] += 1 / inv_length;
        f.extreme[ExtraFigures::bend] = std::max(f.extreme[ExtraFigures::bend], inv_length * bend);
        f.extreme[ExtraFigures::twist_rate] =
            std::max(f.extreme[ExtraFigures::twist_rate], inv_length * std::abs(phi.z));
    }
}

void add_knots(ExtraFigures& f, const RodGroup& group, std::span<const Slot<1>> state) {
    std::vector<Vec3d> node, d1;
    for (const Slot<1>& s : state) {
        node.push_back(lane(s.position, 0));
        d1.push_back(frame(s).d1);
    }
    d1.pop_back(); // the last node has no element
    if (group.closed()) {
        node.pop_back(); // node n is node 0
        f.sum[ExtraFigures::twist] = twist(node, d1, Curve::closed);
        f.sum[ExtraFigures::writhe] = writhe(node, Curve::closed);
        return;
    }
    f.sum[ExtraFigures::twist] = twist(node, d1, Curve::open);
    f.sum[ExtraFigures::writhe] =
        writhe(with_end_segments(node, group.spec().shape.length, EndSegments::next_tangent), Curve::open);
}

/// Of the angle in the plane, cos 2a and sin 2a without the angle.
void add_order(ExtraFigures& f, std::span<const Slot<1>> state) {
    const Vec3d way = lane(state.back().position, 0) - lane(state.front().position, 0);
    const double squared = way.x * way.x + way.y * way.y;
    if (!(squared > 0)) return;
    const double cosine = (way.x * way.x - way.y * way.y) / squared;
    f.sum[ExtraFigures::along_axes] = std::abs(cosine);
    f.sum[ExtraFigures::cosine] = cosine;
    f.sum[ExtraFigures::sine] = 2 * way.x * way.y / squared;
    f.sum[ExtraFigures::directed] = 1;
}

} // namespace

std::vector<std::string> extra_names(const ObservableSets& sets) {
    std::vector<std::string> names;
    const auto add = [&](bool wanted, std::initializer_list<const char*> some) {
        if (wanted) names.insert(names.end(), some.begin(), some.end());
    };
    add(sets.angular_momentum,
        {"angular_momentum_x[kg m^2/s]", "angular_momentum_y[kg m^2/s]", "angular_momentum_z[kg m^2/s]"});
    add(sets.curvature, {"mean_bend_curvature[1/m]", "max_bend_curvature[1/m]", "mean_twist_per_length[rad/m]",
                         "max_twist_per_length[rad/m]"});
    add(sets.knots, {"twist[turns]", "writhe[turns]", "link[turns]"});
    add(sets.order, {"axis_order[-]", "nematic_order[-]"});
    return names;
}

ExtraFigures extra_figures(const RodGroup& group, std::span<const Slot<1>> state, const ObservableSets& sets) {
    ExtraFigures f;
    if (sets.angular_momentum) add_angular_momentum(f, group, state);
    if (sets.curvature) add_curvature(f, group, state);
    if (sets.knots && group.strained()) add_knots(f, group, state);
    if (sets.order && group.strained() && !group.closed()) add_order(f, state);
    return f;
}

std::vector<double> extra_values(const Communicator& comm, std::span<const ExtraFigures> rods,
                                 const ObservableSets& sets) {
    using F = ExtraFigures;
    std::vector<std::vector<double>> columns(F::sums, std::vector<double>(rods.size()));
    std::array<double, F::extremes> extreme{};
    for (std::size_t i = 0; i < rods.size(); ++i) {
        for (std::size_t s = 0; s < F::sums; ++s) columns[s][i] = rods[i].sum[s];
        for (std::size_t x = 0; x < F::extremes; ++x) extreme[x] = std::max(extreme[x], rods[i].extreme[x]);
    }
    const std::vector<double> sum = exact_sums(comm, columns);
    comm.max(extreme);

    std::vector<double> values;
    const auto add = [&](bool wanted, std::initializer_list<double> some) {
        if (wanted) values.insert(values.end(), some.begin(), some.end());
    };
    const double length = sum[F::cell_length] > 0 ? sum[F::cell_length] : 1; // rods of one element have no cell
    add(sets.angular_momentum, {sum[F::angular_x], sum[F::angular_y], sum[F::angular_z]});
    add(sets.curvature,
        {sum[F::bend_length] / length, extreme[F::bend], sum[F::twist_length] / length, extreme[F::twist_rate]});
    const double directed = std::max(sum[F::directed], 1.0);
    add(sets.knots, {sum[F::twist], sum[F::writhe], sum[F::twist] + sum[F::writhe]});
    add(sets.order, {sum[F::along_axes] / directed, std::hypot(sum[F::cosine], sum[F::sine]) / directed});
    return values;
}

} // namespace skein
