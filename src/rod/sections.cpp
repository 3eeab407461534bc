#include "rod/sections.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

namespace {

using std::numbers::pi;

/// Scale of the section of element k along d1.
double first_factor(const Section& section, std::size_t k, const ElementShare& share) {
    return section.profile.empty() ? 1 + (section.taper - 1) * share.middle : section.profile[k];
}

/// Scale of the section of element k along d2.
double second_factor(const Section& section, std::size_t k, const ElementShare& share) {
    return section.profile_2.empty() ? first_factor(section, k, share) : section.profile_2[k];
}

/// Integrals over a section that reaches a along d1 and b along d2. theory.md (3), (3a)
struct SectionIntegrals {
    double a, b;    ///< semi-axes, m
    double area;    ///< A, m^2
    double i1, i2;  ///< integrals of the squared distance from d1 and from d2, m^4
    double torsion; ///< St Venant's constant, m^4
};
SectionIntegrals section_integrals(SectionKind kind, double a, double b) {
    if (kind != SectionKind::rectangular) {
        const double i1 = 0.25 * pi * a * b * b * b, i2 = 0.25 * pi * a * a * a * b;
        return {a, b, pi * a * b, i1, i2, a == b ? i1 + i2 : pi * (a * a * a) * (b * b * b) / (a * a + b * b)};
    }
    const auto [s, l] = std::minmax(a, b);
    const double ratio = s / l, fourth = ratio * ratio * ratio * ratio;
    return {a,
            b,
            4 * a * b,
            4 * a * (b * b * b) / 3,
            4 * (a * a * a) * b / 3,
            l * (s * s * s) * (16.0 / 3 - 3.36 * ratio * (1 - fourth / 12))};
}
SectionIntegrals section_integrals(const RodSpec& spec, double f, double g) {
    const Section& s = spec.section;
    const double a = f * s.radius;
    return section_integrals(s.kind, a, s.kind == SectionKind::circular ? a : g * s.radius_2);
}

double shear_modulus(const Material& m) { return m.shear_modulus > 0 ? m.shear_modulus : m.youngs_modulus / 3; }

/// Bending stiffness of a section that is scaled by f along d1 and by g along d2, N m^2. theory.md (3)
Vec3d bending_stiffness(const RodSpec& spec, double f, double g) {
    const Material& m = spec.material;
    const SectionIntegrals section = section_integrals(spec, f, g);
    const auto& given = spec.section.bending_stiffness;
    // Sections of constant volume are e0 times smaller at rest: theory.md (11d).
    const double e0 = 1 + spec.shape.rest_strain.z, at_rest = m.law == Law::neo_hookean ? 1 / (e0 * e0 * e0) : 1;
    const auto bending = [&](std::size_t axis, double i) {
        return at_rest * (given.empty() ? m.youngs_modulus * i : f * f * f * f * given[axis]);
    };
    const double own = spec.section.torsion_constant, torsion = own > 0 ? f * f * f * f * own : section.torsion;
    return {bending(0, section.i1), bending(1, section.i2), at_rest * (shear_modulus(m) * torsion)};
}

/// Scale of the section at an end of the rod. A profile is extrapolated from the last two elements. The result stays
/// between half and twice the scale of the last element, because a profile may have a step.
double scale_at_end(const std::vector<double>& profile, double taper, const ElementShares& share, std::size_t last,
                    std::size_t next) {
    if (profile.empty()) return last == 0 ? 1 : taper;
    const double l = share[last].length, slope = (profile[last] - profile[next]) / (l + share[next].length);
    return std::clamp(profile[last] + slope * l, 0.5 * profile[last], 2 * profile[last]);
}

/// Scales at elements and nodes along one axis. `factor` gives the scale of an element, `profile` is its table or
/// empty.
template <class Factor> SectionScales section_scales(const RodSpec& spec, const std::vector<ElementConstants>& element,
                                                     Factor&& factor, const std::vector<double>& profile) {
    const ElementShares share(spec.shape);
    const std::size_t n = share.size(), last = n - 1;
    SectionScales scales{std::vector<double>(n), std::vector<double>(n + 1)};
    for (std::size_t k = 0; k < n; ++k) scales.element[k] = factor(spec.section, k, share[k]);
    const auto between = [&](std::size_t before, std::size_t after) {
        const double l = element[before].rest_length, l_after = element[after].rest_length;
        const double f = scales.element[before], f_after = scales.element[after];
        return f == f_after ? f : (l_after * f + l * f_after) / (l + l_after);
    };
    for (std::size_t i = 1; i < n; ++i) scales.node[i] = between(i - 1, i);
    if (spec.shape.closed) scales.node[0] = scales.node[n] = between(last, 0);
    else {
        scales.node[0] = scale_at_end(profile, spec.section.taper, share, 0, std::min<std::size_t>(1, last));
        scales.node[n] = scale_at_end(profile, spec.section.taper, share, last, last > 0 ? last - 1 : 0);
    }
    return scales;
}

} // namespace

ElementShares::ElementShares(const Shape& shape) : shape_(shape) {
    for (const double part : shape.length_profile) sum_ += part;
}

ElementShare ElementShares::operator[](std::size_t k) const {
    const auto n = static_cast<double>(shape_.elements);
    if (shape_.length_profile.empty()) return {1 / n, (static_cast<double>(k) + 0.5) / n};
    if (k < next_) {
        next_ = 0;
        before_ = 0;
    }
    for (; next_ < k; ++next_) before_ += shape_.length_profile[next_];
    return {shape_.length_profile[k] / sum_, (before_ + 0.5 * shape_.length_profile[k]) / sum_};
}

double outer_radius(const RodSpec& spec, std::size_t k, const ElementShare& share) {
    const Section& s = spec.section;
    const double radius = first_factor(s, k, share) * s.radius;
    return s.kind != SectionKind::circular ? std::max(radius, second_factor(s, k, share) * s.radius_2) : radius;
}

ElementConstants element_constants(const RodSpec& spec, std::size_t k, const ElementShare& share) {
    const Material& m = spec.material;
    const double shear = shear_modulus(m);
    const double f = first_factor(spec.section, k, share), g = second_factor(spec.section, k, share);
    const auto [a, b, area, i1, i2, torsion] = section_integrals(spec, f, g);
    const double i3 = i1 + i2;
    const double l = spec.shape.length * share.length;
    const double mass = m.density * l;
    const auto& factors = spec.section.shear_factors;
    const auto factor = [&](std::size_t axis) { return factors.empty() ? m.shear_factor : factors[axis]; };
    return {.rest_length = l,
            .inv_rest_length = 1 / l,
            .volume = area * l,
            .radius = std::sqrt(a * b),
            .stiffness = {factor(0) * shear * area, factor(1) * shear * area, m.youngs_modulus * area},
            .rest_strain = spec.shape.rest_strain,
            .rest_stretch = 1 + spec.shape.rest_strain.z,
            .inertia = {mass * i1, mass * i2, mass * i3},
            .inv_inertia = {1 / (mass * i1), 1 / (mass * i2), 1 / (mass * i3)},
            .inertia_ratio = i3 / i1,
            .bending = bending_stiffness(spec, f, g)};
}

Vec3d rest_curvature_at(const Shape& shape, long k) {
    return shape.rest_curvature_profile.empty() ? shape.rest_curvature : nth(shape.rest_curvature_profile, k);
}

Sections::Sections(const RodSpec& spec, const std::vector<ElementConstants>& element)
    : spec_(spec), element_(element), two_(!spec.section.profile_2.empty()) {
    const Section& section = spec.section;
    if (section.taper == 1 && section.profile.empty() && !two_) return;
    first_ = section_scales(spec, element, first_factor, section.profile);
    if (two_) second_ = section_scales(spec, element, second_factor, section.profile_2);
    vary_ = !(first_.uniform() && second().uniform());
}

Vec3d Sections::stiffness_at_node(std::size_t i) const {
    const auto [f, g] = at_node(i);
    return bending_stiffness(spec_, f, g);
}

VoronoiConstants Sections::cell(std::size_t k) const {
    const std::size_t after = (k + 1) % element_.size();
    const ElementConstants &a = element_[k], &b = element_[after];
    const bool alike =
        !vary_ || (first_.element[k] == first_.element[after] && second().element[k] == second().element[after]);
    const double l = a.rest_length, l_after = b.rest_length, sum = l + l_after;
    return {.inv_length = 2 / sum,
            .share_before = l / sum,
            .share_after = l_after / sum,
            .stiffness = alike ? (1 / sum) * (l * a.bending + l_after * b.bending) : stiffness_at_node(k + 1),
            .rest_curvature = rest_curvature_at(spec_.shape, static_cast<long>(k))};
}

void Sections::put_cells(std::vector<VoronoiConstants>& cells) const {
    const std::size_t n = element_.size();
    cells.clear();
    cells.reserve(n);
    for (std::size_t k = 0; k < to_index(spec_.shape.cells()); ++k) cells.push_back(cell(k));
    if (!vary_ || two_ || spec_.shape.closed || n < 2 || !spec_.shape.length_profile.empty()) return;
    const std::vector<double> scales = cell_scales(first_, spec_.start, spec_.end);
    for (std::size_t i = 1; i < n; ++i)
        if (scales[i] != first_.node[i]) cells[i - 1].stiffness = bending_stiffness(spec_, scales[i], scales[i]);
}

Vec3d Sections::stiffness_at_end(std::size_t k, std::size_t node) const {
    const bool alike = !vary_ || (first_.node[node] == first_.element[k] && second().node[node] == second().element[k]);
    return alike ? element_[k].bending : stiffness_at_node(node);
}

VoronoiConstants Sections::start_wall() const {
    return {2 * element_.front().inv_rest_length, 0, 1, stiffness_at_end(0, 0), rest_curvature_at(spec_.shape, 0)};
}

VoronoiConstants Sections::end_wall() const {
    const std::size_t n = element_.size();
    return {2 * element_.back().inv_rest_length, 1, 0, stiffness_at_end(n - 1, n),
            rest_curvature_at(spec_.shape, spec_.shape.elements - 2)};
}

double Sections::mass_share_before(std::size_t k) const {
    return vary_ ? skein::mass_share_before(at_node(k), at_node(k + 1)) : 0.5;
}

} // namespace skein
