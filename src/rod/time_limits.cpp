#include "rod/time_limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace skein {

namespace {

/// What the law divides B by at dilatation e.
double bending_divisor(const RodGroup& g, double e) { return g.law() == Law::linear ? 1 : e * e * e; }

/// Rotational stiffness over inertia that the cells and walls beside element k hold it with at rest, theory.md (26).
double cell_term(const RodGroup& g, int k, double Vec3d::* axis) {
    const auto j = [&](int i) { return g.element[static_cast<std::size_t>(i)].inertia.*axis; };
    const auto cell = [&](int v, int neighbour) {
        const VoronoiConstants& c = g.voronoi[static_cast<std::size_t>(v)];
        const int after = (v + 1) % g.elements();
        const double dilatation = c.share_before * g.element[static_cast<std::size_t>(v)].rest_stretch +
                                  c.share_after * g.element[static_cast<std::size_t>(after)].rest_stretch;
        return c.stiffness.*axis * c.inv_length / bending_divisor(g, dilatation) * (1 / j(k) + 1 / j(neighbour));
    };
    const int n = g.elements(), before = (k + n - 1) % n, after = (k + 1) % n;
    double beta = 0;
    if (k > 0 || g.closed()) beta += cell(before, before);
    if (k + 1 < n || g.closed()) beta += cell(k, after);
    const ElementConstants& e = g.element[static_cast<std::size_t>(k)];
    const double wall = e.bending.*axis * 2 * e.inv_rest_length / (bending_divisor(g, e.rest_stretch) * j(k));
    if (k == 0 && g.spec().start == EndKind::clamped) beta += wall;
    if (k + 1 == g.elements() && g.spec().end == EndKind::clamped) beta += wall;
    return beta;
}

/// Largest eigenvalue of the element's shear and rotation about `axis`, sheared along `along`.
double shear_rotation(const RodGroup& g, int k, double Vec3d::* axis, double Vec3d::* along, double inverse_mass) {
    const ElementConstants& c = g.element[static_cast<std::size_t>(k)];
    const double s = c.stiffness.*along, j = c.inertia.*axis, e = c.rest_stretch;
    const double a = s * inverse_mass * c.inv_rest_length;
    const double d = c.rest_length * s * e * e / j + cell_term(g, k, axis);
    const double b = s * e * std::sqrt(inverse_mass / j);
    return 0.5 * (a + d + std::sqrt((a - d) * (a - d) + 4 * b * b));
}

} // namespace

std::vector<TimeLimit> time_limits(const RodGroup& g) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    std::vector<TimeLimit> limits = {{"axial", infinite, 0}, {"shear-rotation about d1", infinite, 0}, {"shear-rotation about d2", infinite, 0}, {"twist", infinite, 0}};
    const auto lower = [](TimeLimit& limit, double eigenvalue, int k) {
        const double dt = 2 / std::sqrt(eigenvalue);
        if (dt < limit.dt) limit = {limit.mode, dt, k};
    };
    for (int k = 0; k < g.elements(); ++k) {
        const ElementConstants& c = g.element[static_cast<std::size_t>(k)];
        const double inverse_mass = 4 / (g.spec().material.density * c.volume); // 1/mL + 1/mR, half of the element on each side
        const double axial = g.law() == Law::linear ? c.stiffness.z : c.stiffness.z / c.rest_stretch;
        lower(limits[0], axial * inverse_mass * c.inv_rest_length, k);
        lower(limits[1], shear_rotation(g, k, &Vec3d::x, &Vec3d::y, inverse_mass), k);
        lower(limits[2], shear_rotation(g, k, &Vec3d::y, &Vec3d::x, inverse_mass), k);
        lower(limits[3], cell_term(g, k, &Vec3d::z), k);
    }
    std::stable_sort(limits.begin(), limits.end(), [](const TimeLimit& a, const TimeLimit& b) { return a.dt < b.dt; });
    return limits;
}

double tension_limit(const RodGroup& g) {
    const Material& m = g.spec().material;
    const double shear = m.shear_factor * (m.shear_modulus > 0 ? m.shear_modulus : m.youngs_modulus / 3);
    const double e0 = 1 + g.spec().shape.rest_strain.z;
    if (g.law() != Law::incompressible) return shear < m.youngs_modulus ? e0 / (1 - shear / m.youngs_modulus) : std::numeric_limits<double>::infinity();
    const double discriminant = 1 - 4 * e0 * shear / m.youngs_modulus;
    if (discriminant <= 0) return std::numeric_limits<double>::infinity();
    return (1 - std::sqrt(discriminant)) * m.youngs_modulus / (2 * shear);
}

} // namespace skein
