#include "rod/time_limits.hpp"

#include "parallel/pieces.hpp"
#include "rod/rest_stiffness.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace skein {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Rotational stiffness over inertia, from the cells and walls beside element k at rest, theory.md (26). `j(i)` is J of
/// element i.
template <class Inertia> double cell_term(const RodGroup& g, int k, double Vec3d::*axis, const Inertia& j) {
    const auto cell = [&](int v, int neighbour) {
        const VoronoiConstants& c = nth(g.voronoi, v);
        return c.stiffness.*axis * c.inv_length / bending_divisor(g, rest_dilatation(g, v)) *
               (1 / j(k) + 1 / j(neighbour));
    };
    double beta = 0;
    if (const int before = g.element_before(k); before >= 0) beta += cell(before, before);
    if (const int after = g.element_after(k + 1); after >= 0) beta += cell(k, after);
    const ElementConstants& e = nth(g.element, k);
    const auto wall = [&](const VoronoiConstants& c) {
        return c.stiffness.*axis * c.inv_length / (bending_divisor(g, e.rest_stretch) * j(k));
    };
    if (k == 0 && g.spec().start == EndKind::clamped) beta += wall(g.start_wall);
    if (k + 1 == g.elements() && g.spec().end == EndKind::clamped) beta += wall(g.end_wall);
    return beta;
}

double cell_term(const RodGroup& g, int k, double Vec3d::*axis) {
    return cell_term(g, k, axis, [&](int i) { return nth(g.element, i).inertia.*axis; });
}

/// Inverse mass 1/m for the stretching of element k, half of it on each side.
double inverse_mass_of(const RodGroup& g, int k) { return 4 / (g.nodal_density * nth(g.element, k).volume); }

/// Largest eigenvalue of shear along `along` and rotation about `axis` of an element.
double shear_rotation(const RodGroup& g, int k, double Vec3d::*axis, double Vec3d::*along, double inverse_mass,
                      double held = 0) {
    const ElementConstants& c = nth(g.element, k);
    const double s = c.stiffness.*along, j = c.inertia.*axis, e = c.rest_stretch;
    const double a = s * inverse_mass * c.inv_rest_length;
    const double d = c.rest_length * s * e * e / j + (cell_term(g, k, axis) + held);
    const double b = s * e * std::sqrt(inverse_mass / j);
    return 0.5 * (a + d + std::sqrt((a - d) * (a - d) + 4 * b * b));
}

/// Factor j of element k at which (27) has the eigenvalue `aim`: there (aim - a)(aim - d) = b^2, and both d - others
/// and b^2 go as 1/j. `own` and `others` are the parts of beta with 1/J of the element and of its neighbours. The
/// result is not positive where there is no such j.
double scale_at(const RodGroup& g, int k, double Vec3d::*axis, double Vec3d::*along, double own, double others,
                double aim) {
    const ElementConstants& c = nth(g.element, k);
    const double s = c.stiffness.*along, j = c.inertia.*axis, e = c.rest_stretch, inverse_mass = inverse_mass_of(g, k);
    const double a = s * inverse_mass * c.inv_rest_length, d = c.rest_length * s * e * e / j + own,
                 b_squared = s * s * e * e * inverse_mass / j;
    return aim > a ? (d + b_squared / (aim - a)) / (aim - others) : -1;
}

/// Limits of a group whose rods have its sizes, in the order of limiting_modes.
std::array<TimeLimit, limiting_modes.size()> limits_by_mode(const RodGroup& g) {
    std::array<TimeLimit, limiting_modes.size()> limits;
    for (std::size_t mode = 0; mode < limits.size(); ++mode) limits[mode] = {limiting_modes[mode], infinite, 0};
    const auto lower = [](TimeLimit& limit, double eigenvalue, int k) {
        const double dt = 2 / std::sqrt(eigenvalue);
        // A limit that is not a number stays, and is refused later.
        if (!std::isnan(limit.dt) && !(dt >= limit.dt)) limit = {limit.mode, dt, k};
    };
    for (int k = 0; k < g.elements(); ++k) {
        const ElementConstants& c = nth(g.element, k);
        const double inverse_mass = inverse_mass_of(g, k);
        lower(limits[0], axial_stiffness(g, c) * inverse_mass * c.inv_rest_length, k);
        lower(limits[1], shear_rotation(g, k, &Vec3d::x, &Vec3d::y, inverse_mass), k);
        lower(limits[2], shear_rotation(g, k, &Vec3d::y, &Vec3d::x, inverse_mass), k);
        lower(limits[3], cell_term(g, k, &Vec3d::z), k);
    }
    return limits;
}

/// Refuses a rod whose numbers are so small or so large that no step is left.
[[noreturn]] void refuse_size(const RodGroup& g, std::int64_t i, const TimeLimit& limit) {
    const RodSpec& spec = g.spec();
    const Places& places = g.places();
    throw InputError(fmt::format(
        "{}: file '{}', row {}: a rod of '{}' with length {:g} m and radius {:g} m has a limit of the time step of "
        "{:g} s ({} mode): correct its numbers",
        spec.source, spec.placement.file, i, spec.name, places.length(i, spec.shape.length),
        places.radius(i, spec.section.radius), limit.dt, limit.mode));
}

} // namespace

std::vector<TimeLimit> time_limits(const RodGroup& g) {
    if (!g.strained()) return {{"none (rigid)", infinite, 0}};
    const auto by_mode = limits_by_mode(g);
    std::vector<TimeLimit> limits(by_mode.begin(), by_mode.end());
    if (g.heterogeneous())
        for (std::size_t mode = 0; mode < limits.size(); ++mode) limits[mode].dt = g.least_limits()[mode];
    std::stable_sort(limits.begin(), limits.end(), [](const TimeLimit& a, const TimeLimit& b) {
        return std::isnan(a.dt) ? !std::isnan(b.dt) : a.dt < b.dt;
    });
    return limits;
}

double eigenvalue_of_element(const RodGroup& g, int k, const Vec3d& held) {
    const double inverse_mass = inverse_mass_of(g, k);
    return std::max({shear_rotation(g, k, &Vec3d::x, &Vec3d::y, inverse_mass, held.x),
                     shear_rotation(g, k, &Vec3d::y, &Vec3d::x, inverse_mass, held.y),
                     cell_term(g, k, &Vec3d::z) + held.z});
}

LeastLimits least_limits_of_rods(const RodGroup& g, const Threads* threads) {
    constexpr std::size_t piece = 128;
    std::vector<std::optional<RodGroup>> rod_of_thread(threads_in(threads));
    LeastLimits least;
    least.fill(infinite);
    const auto consider = [&](std::int64_t i, std::size_t thread, LeastLimits& so_far) {
        std::optional<RodGroup>& rod = rod_of_thread[thread];
        if (rod) rod->become(g, i, g.closed() ? RodGroup::Part::whole : RodGroup::Part::constants); // rings must close
        else rod.emplace(g.single(i));
        const auto limits = limits_by_mode(*rod);
        for (const TimeLimit& limit : limits)
            if (!(limit.dt > 0)) refuse_size(g, i, limit);
        for (std::size_t mode = 0; mode < so_far.size(); ++mode) so_far[mode] = std::min(so_far[mode], limits[mode].dt);
    };
    const Places& places = g.places();
    if (places.columns().nodes || places.columns().radii || g.spec().material.inertia_chosen) {
        const std::vector<std::int64_t> held = places.held();
        std::vector<LeastLimits> of_piece((held.size() + piece - 1) / piece, least);
        in_pieces(threads, held.size(), piece,
                  [&](std::size_t begin, std::size_t end, std::size_t thread, std::size_t number) {
                      for (std::size_t i = begin; i < end; ++i) consider(held[i], thread, of_piece[number]);
                  });
        for (const LeastLimits& one : of_piece)
            for (std::size_t mode = 0; mode < least.size(); ++mode) least[mode] = std::min(least[mode], one[mode]);
        return least;
    }
    // Every entry of the matrices of (26)-(29) falls with the length and with the radius of the whole rod, and so do
    // their largest eigenvalues. The smallest limit thus belongs to a rod that no other undercuts in both: some dozens
    // of a million.
    struct Size {
        double length, radius;
        std::int64_t rod;
    };
    std::vector<Size> smallest;
    for (const std::int64_t i : places.held()) {
        const Size size{places.length(i, g.spec().shape.length), places.radius(i, g.spec().section.radius), i};
        const auto undercuts = [](const Size& a, const Size& b) {
            return a.length <= b.length && a.radius <= b.radius;
        };
        if (std::any_of(smallest.begin(), smallest.end(), [&](const Size& s) { return undercuts(s, size); })) continue;
        std::erase_if(smallest, [&](const Size& s) { return undercuts(size, s); });
        smallest.push_back(size);
    }
    for (const Size& s : smallest) consider(s.rod, 0, least);
    return least;
}

std::vector<double> rotary_inertia_for(const RodGroup& g, double dt) {
    const double aim = 4 / (dt * dt);
    const std::size_t n = to_index(g.elements());
    std::vector<double> alike(n, 1.0), scale;
    const auto raise = [&](double& j, int k, double Vec3d::*axis, double Vec3d::*along, const auto& beta_of) {
        const auto [own, others] = beta_of(axis);
        const double least = scale_at(g, k, axis, along, own, others, aim);
        if (!(least > 0))
            throw InputError(
                fmt::format("{}: 'rotary_inertia_for_dt' of {:g} s is out of reach for element {} of '{}': its shear "
                            "has a limit that rotary inertia does not lift",
                            g.spec().source, dt, k, g.name()));
        j = std::max(j, least * (1 + 1e-12)); // round-off must leave the limit above dt
    };
    const auto raise_both = [&](double& j, int k, const auto& beta_of) {
        raise(j, k, &Vec3d::x, &Vec3d::y, beta_of);
        raise(j, k, &Vec3d::y, &Vec3d::x, beta_of);
    };
    // First pass: neighbours have the same j. Second pass: they have the j of the first. More inertia only helps a
    // neighbour, so two passes suffice.
    for (int k = 0; k < g.elements(); ++k)
        raise_both(nth(alike, k), k, [&](double Vec3d::*axis) { return std::pair(cell_term(g, k, axis), 0.0); });
    scale = alike;
    for (int k = 0; k < g.elements(); ++k)
        raise_both(nth(scale, k), k, [&](double Vec3d::*axis) {
            const auto at = [&](int i) { return nth(g.element, i).inertia.*axis; };
            const double own = cell_term(g, k, axis, [&](int i) { return i == k ? at(i) : infinite; });
            const double others =
                cell_term(g, k, axis, [&](int i) { return i == k ? infinite : nth(alike, i) * at(i); });
            return std::pair(own, others);
        });
    return scale;
}

double tension_limit(const RodGroup& g) {
    if (!g.strained()) return infinite;
    const Material& m = g.spec().material;
    const auto& factors = g.spec().section.shear_factors;
    const double factor = factors.empty() ? m.shear_factor : std::min(factors[0], factors[1]);
    const double shear = factor * (m.shear_modulus > 0 ? m.shear_modulus : m.youngs_modulus / 3);
    const double e0 = 1 + g.spec().shape.rest_strain.z;
    if (g.law() == Law::neo_hookean) {
        const double rest = 1 - 3 * shear * e0 * e0 / m.youngs_modulus;
        return rest > 0 ? e0 / std::cbrt(rest) : infinite;
    }
    if (g.law() != Law::incompressible)
        return shear < m.youngs_modulus ? e0 / (1 - shear / m.youngs_modulus) : infinite;
    const double discriminant = 1 - 4 * e0 * shear / m.youngs_modulus;
    if (discriminant <= 0) return infinite;
    return (1 - std::sqrt(discriminant)) * m.youngs_modulus / (2 * shear);
}

} // namespace skein
