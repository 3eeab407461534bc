#include "diagnostics/extra_observables.hpp"

#include "core/rotation.hpp"
#include "diagnostics/knots.hpp"
#include "parallel/exact_sum.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

using State = std::span<const Slot<1>>;
using F = ExtraFigures;

void add_angular_momentum(F& f, const RodGroup& group, State state) {
    Vec3d sum{0, 0, 0};
    for (std::size_t i = 0; i < state.size(); ++i)
        sum += group.node_mass[i] * cross(lane(state[i].position, 0), lane(state[i].velocity, 0));
    for (std::size_t k = 0; k < group.element.size(); ++k)
        sum += transpose_times(lane(state[k].director, 0), scale(group.element[k].inertia, lane(state[k].spin, 0)));
    f.sum[F::angular_x] = sum.x;
    f.sum[F::angular_y] = sum.y;
    f.sum[F::angular_z] = sum.z;
}

void add_curvature(F& f, const RodGroup& group, State state) {
    for (std::size_t k = 0; k < group.voronoi.size(); ++k) {
        const double inv_length = group.voronoi[k].inv_length / cell_weight(group, k + 1);
        const Vec3d phi = lane(relative_rotation(state[(k + 1) % group.element.size()].director, state[k].director), 0);
        const double bend = std::hypot(phi.x, phi.y);
        f.sum[F::bend_length] += bend;
        f.sum[F::twist_length] += phi.z;
        f.sum[F::cell_length] += 1 / inv_length;
        f.extreme[F::bend] = std::max(f.extreme[F::bend], inv_length * bend);
        f.extreme[F::twist_rate] = std::max(f.extreme[F::twist_rate], inv_length * std::abs(phi.z));
    }
}

void add_knots(F& f, const RodGroup& group, State state) {
    std::vector<Vec3d> node, d1;
    for (const Slot<1>& s : state) {
        node.push_back(lane(s.position, 0));
        d1.push_back(frame(s).d1);
    }
    d1.pop_back(); // the last node has no element
    if (group.closed()) {
        node.pop_back(); // node n is node 0
        f.sum[F::twist] = twist(node, d1, Curve::closed);
        f.sum[F::writhe] = writhe(node, Curve::closed);
        return;
    }
    f.sum[F::twist] = twist(node, d1, Curve::open);
    f.sum[F::writhe] =
        writhe(with_end_segments(node, group.spec().shape.length, EndSegments::next_tangent), Curve::open);
}

/// Finds cos 2a and sin 2a of the angle a in the plane without the angle.
void add_order(F& f, State state) {
    const Vec3d way = lane(state.back().position, 0) - lane(state.front().position, 0);
    const double squared = way.x * way.x + way.y * way.y;
    if (!(squared > 0)) return;
    const double cosine = (way.x * way.x - way.y * way.y) / squared;
    f.sum[F::along_axes] = std::abs(cosine);
    f.sum[F::cosine] = cosine;
    f.sum[F::sine] = 2 * way.x * way.y / squared;
    f.sum[F::directed] = 1;
}

using Sums = const std::vector<double>&;
using Extremes = const std::array<double, F::extremes>&;
using Sets = ObservableSets;

double per_length(Sums sum, F::Sum of) {
    return sum[of] / (sum[F::cell_length] > 0 ? sum[F::cell_length] : 1); // rods of one element have no cell
}
double per_directed(Sums sum, double value) { return value / std::max(sum[F::directed], 1.0); }

/// Observable of a set, from sums and maxima over all rods.
struct Extra {
    bool Sets::*set;
    const char* name;
    double (*value)(Sums sum, Extremes extreme);
};
constexpr Extra extras[] = {
    {&Sets::angular_momentum, "angular_momentum_x[kg m^2/s]", [](Sums s, Extremes) { return s[F::angular_x]; }},
    {&Sets::angular_momentum, "angular_momentum_y[kg m^2/s]", [](Sums s, Extremes) { return s[F::angular_y]; }},
    {&Sets::angular_momentum, "angular_momentum_z[kg m^2/s]", [](Sums s, Extremes) { return s[F::angular_z]; }},
    {&Sets::curvature, "mean_bend_curvature[1/m]", [](Sums s, Extremes) { return per_length(s, F::bend_length); }},
    {&Sets::curvature, "max_bend_curvature[1/m]", [](Sums, Extremes most) { return most[F::bend]; }},
    {&Sets::curvature, "mean_twist_per_length[rad/m]", [](Sums s, Extremes) { return per_length(s, F::twist_length); }},
    {&Sets::curvature, "max_twist_per_length[rad/m]", [](Sums, Extremes most) { return most[F::twist_rate]; }},
    {&Sets::knots, "twist[turns]", [](Sums s, Extremes) { return s[F::twist]; }},
    {&Sets::knots, "writhe[turns]", [](Sums s, Extremes) { return s[F::writhe]; }},
    {&Sets::knots, "link[turns]", [](Sums s, Extremes) { return s[F::twist] + s[F::writhe]; }},
    {&Sets::order, "axis_order[-]", [](Sums s, Extremes) { return per_directed(s, s[F::along_axes]); }},
    {&Sets::order, "nematic_order[-]",
     [](Sums s, Extremes) { return per_directed(s, std::hypot(s[F::cosine], s[F::sine])); }}};

} // namespace

std::vector<std::string> extra_names(const ObservableSets& sets) {
    std::vector<std::string> names;
    for (const Extra& extra : extras)
        if (sets.*extra.set) names.emplace_back(extra.name);
    return names;
}

ExtraFigures extra_figures(const RodGroup& group, std::span<const Slot<1>> state, const ObservableSets& sets) {
    F f;
    if (sets.angular_momentum) add_angular_momentum(f, group, state);
    if (sets.curvature) add_curvature(f, group, state);
    if (sets.knots && group.strained()) add_knots(f, group, state);
    if (sets.order && group.strained() && !group.closed()) add_order(f, state);
    return f;
}

std::vector<double> extra_values(const Communicator& comm, const Threads& threads, std::span<const ExtraFigures> rods,
                                 const ObservableSets& sets) {
    std::array<double, F::extremes> extreme{};
    for (const F& rod : rods)
        for (std::size_t x = 0; x < F::extremes; ++x) extreme[x] = std::max(extreme[x], rod.extreme[x]);
    const std::vector<double> sum = exact_sums(
        comm, threads, {rods.empty() ? nullptr : rods[0].sum.data(), rods.size(), F::sums, sizeof(F) / sizeof(double)});
    comm.max(extreme);
    std::vector<double> values;
    for (const Extra& extra : extras)
        if (sets.*extra.set) values.push_back(extra.value(sum, extreme));
    return values;
}

} // namespace skein
