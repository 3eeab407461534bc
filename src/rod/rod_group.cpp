#include "skein/rod/rod_group.hpp"

#include "core/rotation.hpp"
#include "placement/packing.hpp"
#include "rod/body_shape.hpp"
#include "rod/cell_turn.hpp"
#include "rod/end_weights.hpp"
#include "rod/held.hpp"
#include "rod/own_sizes.hpp"
#include "rod/rows_memory.hpp"
#include "rod/taper.hpp"
#include "rod/time_limits.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

namespace skein {

namespace {

constexpr double pi = std::numbers::pi;

bool same(const Quaterniond& a, const Quaterniond& b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool is_no_turn(const Quaterniond& q) { return same(q, no_turn); }

/// Where an element lies: its rest length and the arc length of its middle, both over the rod's length.
struct Share {
    double length, middle;
};

/// Of all elements, in their order; asked for in that order they take no memory.
class Shares {
public:
    explicit Shares(const Shape& shape) : shape_(shape) {
        for (const double part : shape.length_profile) sum_ += part;
    }
    std::size_t size() const { return static_cast<std::size_t>(shape_.elements); }
    Share operator[](std::size_t k) const {
        const auto n = static_cast<double>(shape_.elements);
        if (shape_.length_profile.empty()) return {1 / n, (static_cast<double>(k) + 0.5) / n};
        if (k < next_) {
            next_ = 0;
            before_ = 0;
        }
        for (; next_ < k; ++next_) before_ += shape_.length_profile[next_];
        return {shape_.length_profile[k] / sum_, (before_ + 0.5 * shape_.length_profile[k]) / sum_};
    }

private:
    const Shape& shape_;
    double sum_ = 0;
    mutable double before_ = 0; ///< of elements before `next_`
    mutable std::size_t next_ = 0;
};

double radius_factor(const Section& section, std::size_t k, const Share& share) {
    return section.profile.empty() ? 1 + (section.taper - 1) * share.middle : section.profile[k];
}

/// The same of the semi-axis along d2.
double second_factor(const Section& section, std::size_t k, const Share& share) {
    return section.profile_2.empty() ? radius_factor(section, k, share) : section.profile_2[k];
}

/// Of the largest section, whichever way it lies.
double outer_radius(const RodSpec& spec, std::size_t k, const Share& share) {
    const Section& s = spec.section;
    const double radius = radius_factor(s, k, share) * s.radius;
    return s.kind != SectionKind::circular ? std::max(radius, second_factor(s, k, share) * s.radius_2) : radius;
}

/// Integrals over a section that reaches a along d1 and b along d2.                                         theory.md
/// (3), (3a)
struct SectionIntegrals {
    double a, b;    ///< m
    double area;    ///< m^2
    double i1, i2;  ///< of the squared distance from d1, and from d2, m^4
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

/// Of a section that is scaled by f along d1 and by g along d2.                                       theory.md (3)
Vec3d bending_stiffness(const RodSpec& spec, double f, double g) {
    const Material& m = spec.material;
    const double shear = m.shear_modulus > 0 ? m.shear_modulus : m.youngs_modulus / 3;
    const SectionIntegrals section = section_integrals(spec, f, g);
    const auto& given = spec.section.bending_stiffness;
    // Sections of constant volume are e0 times smaller at rest: theory.md (11d).
    const double e0 = 1 + spec.shape.rest_strain.z, at_rest = m.law == Law::neo_hookean ? 1 / (e0 * e0 * e0) : 1;
    const auto bending = [&](std::size_t axis, double i) {
        return at_rest * (given.empty() ? m.youngs_modulus * i : f * f * f * f * given[axis]);
    };
    const double own = spec.section.torsion_constant, torsion = own > 0 ? f * f * f * f * own : section.torsion;
    return {bending(0, section.i1), bending(1, section.i2), at_rest * (shear * torsion)};
}

/// Constants of one element from its section: A, I1 = integral of y^2, I2, I3 = I1 + I2.      theory.md (3)
ElementConstants element_constants(const RodSpec& spec, std::size_t k, const Share& share) {
    const Material& m = spec.material;
    const double shear = m.shear_modulus > 0 ? m.shear_modulus : m.youngs_modulus / 3;
    const double f = radius_factor(spec.section, k, share), g = second_factor(spec.section, k, share);
    const auto [a, b, area, i1, i2, torsion] = section_integrals(spec, f, g);
    const double i3 = i1 + i2;
    const double l = spec.shape.length * share.length;
    const double mass = m.density * l;
    const auto& factors = spec.section.shear_factors;
    const double e0 = 1 + spec.shape.rest_strain.z;
    const auto factor = [&](std::size_t axis) { return factors.empty() ? m.shear_factor : factors[axis]; };
    return {.rest_length = l,
            .inv_rest_length = 1 / l,
            .volume = area * l,
            .radius = std::sqrt(a * b),
            .stiffness = {factor(0) * shear * area, factor(1) * shear * area, m.youngs_modulus * area},
            .rest_strain = spec.shape.rest_strain,
            .rest_stretch = e0,
            .inertia = {mass * i1, mass * i2, mass * i3},
            .inv_inertia = {1 / (mass * i1), 1 / (mass * i2), 1 / (mass * i3)},
            .inertia_ratio = i3 / i1,
            .bending = bending_stiffness(spec, f, g)};
}

/// Every element's j; empty where all are 1. `group` has its elements and cells, not scaled.
std::vector<double> rotary_inertia_scales(const RodGroup& group) {
    const Material& m = group.spec().material;
    std::vector<double> scales;
    if (m.rotary_inertia_for_dt > 0) scales = rotary_inertia_for(group, m.rotary_inertia_for_dt);
    else if (m.rotary_inertia_scale > 1) scales.assign(group.element.size(), m.rotary_inertia_scale);
    const bool scaled = std::any_of(scales.begin(), scales.end(), [](double j) { return j > 1; });
    return scaled ? scales : std::vector<double>{};
}

/// Not the axial one: scaled too, it raises piles with friction by 2.5 to 2.9 %, the transverse ones alone by 0.3 %.
void scale_rotary_inertia(ElementConstants& c, double j) {
    c.inertia = {j * c.inertia.x, j * c.inertia.y, c.inertia.z};
    c.inv_inertia = {1 / c.inertia.x, 1 / c.inertia.y, c.inv_inertia.z};
    c.inertia_ratio = c.inertia.z / c.inertia.x;
}

// Cells and half cells have the stiffness of the section at their node, of which the scale is on the line through those
// at the middles of the elements beside, or of what taper.hpp puts in its place. A mean of stiffnesses is not near,
// which go as its fourth power.

/// Cell between elements, whose own section has these scales along d1 and d2.
VoronoiConstants voronoi_constants(const RodSpec& spec, const ElementConstants& before, const ElementConstants& after,
                                   bool same_section, double scale, double scale_2, const Vec3d& rest_curvature) {
    const double l = before.rest_length, l_after = after.rest_length, sum = l + l_after;
    return {.inv_length = 2 / sum,
            .share_before = l / sum,
            .share_after = l_after / sum,
            .stiffness = same_section ? (1 / sum) * (l * before.bending + l_after * after.bending)
                                      : bending_stiffness(spec, scale, scale_2),
            .rest_curvature = rest_curvature};
}

/// Scale of the section at an end of the rod: where a profile gives it, on the line through the last element's and the
/// next one's, but half to twice the last element's, should there be a step.
double scale_at_end(const std::vector<double>& profile, double taper, const Shares& share, std::size_t last,
                    std::size_t next) {
    if (profile.empty()) return last == 0 ? 1 : taper;
    const double l = share[last].length, slope = (profile[last] - profile[next]) / (l + share[next].length);
    return std::clamp(profile[last] + slope * l, 0.5 * profile[last], 2 * profile[last]);
}

/// `factor`: of an element's section; `profile`: where that is given by element.
template <class Factor> SectionScales section_scales(const RodSpec& spec, const std::vector<ElementConstants>& element,
                                                     Factor&& factor, const std::vector<double>& profile) {
    const Shares share(spec.shape);
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

/// What a scene leaves out: a ring that says nothing of its curvature is a circle; a body is an element as long as it
/// reaches both ways.
RodSpec completed(RodSpec spec, const BodyShape* body) {
    Shape& s = spec.shape;
    if (body) {
        s.elements = 1;
        s.length = 2 * body->reach;
        spec.material.density = body->mass / body->volume;
        return spec;
    }
    const bool straight = s.rest_curvature.x == 0 && s.rest_curvature.y == 0 && s.rest_curvature.z == 0 &&
                          s.rest_curvature_profile.empty();
    if (s.closed && straight && !s.start_curvature && s.start_curvature_profile.empty())
        s.rest_curvature = {2 * pi / s.length, 0, 0};
    return spec;
}

} // namespace

RodGroup::RodGroup(const RodSpec& spec, int id, std::int64_t first_gid, const std::string& directory,
                   std::vector<Capsule>* occupied, std::shared_ptr<const RodSource> source)
    : body_(spec.body ? std::make_shared<const BodyShape>(spec) : nullptr), spec_(completed(spec, body_.get())),
      id_(id), first_gid_(first_gid),
      places_(source ? Places(std::move(source), spec.placement.origin, spec.shape.elements)
                     : Places(spec_.placement, spec_.source, directory)) {
    spec_.placement.origins = spec_.placement.tangents = spec_.placement.normals = {}; // places_ has them
    frame_ = turned() ? no_turn : frame_of(spec.placement.tangent, spec.placement.normal);
    work_out_constants();
    if (spec_.placement.kind == PlacementKind::packing) pack_rods(occupied);
    if (!places_.from_file()) corner_ = places_.corner();
}

RodGroup::RodGroup(const RodGroup& group, std::int64_t i)
    : body_(group.body_), spec_(group.spec_), id_(group.id_), first_gid_(group.first_gid_), frame_(group.frame_),
      corner_(group.corner_) {
    become(group, i);
}

void RodGroup::become(const RodGroup& group, std::int64_t i) {
    put_sizes(group.places_, group.spec_, i, spec_);
    places_.become(group.places_, i);
    work_out_constants();
}

int RodGroup::exposed_slots() const { return body_ ? 2 * static_cast<int>(body_->part.size()) : slots(); }

double RodGroup::exposed_radius(int slot) const {
    const auto at = static_cast<std::size_t>(slot);
    if (body_) return at % 2 ? -1 : body_->part[at / 2].cover();
    return at < element.size() ? element[at].radius : -1;
}

/// One slot: the centre of mass, and the principal axes.
void RodGroup::work_out_body() {
    const BodyShape& body = *body_;
    const Vec3d &j = body.inertia, inverse{1 / j.x, 1 / j.y, 1 / j.z};
    double widest = 0;
    for (const BodyShape::Part& part : body.part) widest = std::max(widest, part.radius);
    const double length = spec_.shape.length;
    element = {{.rest_length = length,
                .inv_rest_length = 1 / length,
                .volume = body.volume,
                .radius = widest,
                .stiffness = {0, 0, 0},
                .rest_strain = {0, 0, 0},
                .rest_stretch = 1,
                .inertia = j,
                .inv_inertia = inverse,
                .inertia_ratio = j.z / j.x,
                .bending = {0, 0, 0}}};
    node_mass = {body.mass};
    node_length = {length};
    end_frame_ = frame_;
    start_directors_ = {is_no_turn(body.axes) ? frame_ : body.axes * frame_};
    centre_offset_ = transpose_times(frame_, body.centre);
    start_offsets_ = {centre_offset_};
}

void RodGroup::work_out_constants() {
    if (body_) return work_out_body();
    const Shape& shape = spec_.shape;
    const long n = shape.elements, cells = closed() ? n : n - 1;
    const auto begin = [](auto& list, long size) {
        list.clear();
        list.reserve(static_cast<std::size_t>(size));
    };
    begin(start_offsets_, n + 1);
    begin(element, n);
    begin(voronoi, n);
    begin(start_directors_, n);
    const Shares share(shape);
    for (std::size_t k = 0; k < share.size(); ++k) element.push_back(element_constants(spec_, k, share[k]));
    const auto kappa0 = [&](long k) {
        return shape.rest_curvature_profile.empty() ? shape.rest_curvature : nth(shape.rest_curvature_profile, k);
    };
    const Section& section = spec_.section;
    const bool two = !section.profile_2.empty(), tapers = section.taper != 1 || !section.profile.empty() || two;
    const SectionScales scales =
        tapers ? section_scales(spec_, element, radius_factor, section.profile) : SectionScales{};
    const SectionScales scales_2 = two ? section_scales(spec_, element, second_factor, section.profile_2) : scales;
    const bool varies = tapers && !(scales.uniform() && scales_2.uniform());
    const auto scale_at = [&](std::size_t node) { return varies ? scales.node[node] : 1; };
    const auto scale_2_at = [&](std::size_t node) { return varies ? scales_2.node[node] : 1; };
    const auto same_section = [&](std::size_t before, std::size_t after) {
        return !varies ||
               (scales.element[before] == scales.element[after] && scales_2.element[before] == scales_2.element[after]);
    };
    for (long k = 0; k < cells; ++k) {
        const auto before = static_cast<std::size_t>(k), after = static_cast<std::size_t>((k + 1) % n);
        voronoi.push_back(voronoi_constants(spec_, element[before], element[after], same_section(before, after),
                                            scale_at(before + 1), scale_2_at(before + 1), kappa0(k)));
    }
    if (varies && !two && !closed() && n > 1 && shape.length_profile.empty()) {
        const std::vector<double> cell = cell_scales(scales, spec_.start, spec_.end);
        for (std::size_t k = 0; k < voronoi.size(); ++k)
            if (cell[k + 1] != scales.node[k + 1])
                voronoi[k].stiffness = bending_stiffness(spec_, cell[k + 1], cell[k + 1]);
    }
    const auto last = static_cast<std::size_t>(n - 1);
    const auto stiffness_at_end = [&](std::size_t k, std::size_t node) {
        const bool same =
            !varies || (scales.node[node] == scales.element[k] && scales_2.node[node] == scales_2.element[k]);
        return same ? element[k].bending : bending_stiffness(spec_, scales.node[node], scales_2.node[node]);
    };
    start_wall = {2 * element[0].inv_rest_length, 0, 1, stiffness_at_end(0, 0), kappa0(0)};
    end_wall = {2 * element[last].inv_rest_length, 1, 0, stiffness_at_end(last, last + 1), kappa0(n - 2)};
    weigh_cells();
    // Part of an element's mass that is its first node's.
    const auto share_before = [&](std::size_t k) {
        return varies
                   ? mass_share_before({scales.node[k], scales_2.node[k]}, {scales.node[k + 1], scales_2.node[k + 1]})
                   : 0.5;
    };
    const bool masses_weighted = takes_end_weights(spec_) && (weighs_masses(spec_.start) || weighs_masses(spec_.end));
    double inverse_mass = masses_weighted ? inverse_mass_of_ends() : 1; // 1/m + 1/m' over that of halves: the largest
    for (std::size_t k = 0; varies && k < share.size(); ++k)
        inverse_mass = std::max(inverse_mass, 0.25 / (share_before(k) * (1 - share_before(k))));
    nodal_density = spec_.material.density / inverse_mass;
    rotary_inertia_scale = rotary_inertia_scales(*this);
    for (std::size_t k = 0; k < rotary_inertia_scale.size(); ++k)
        scale_rotary_inertia(element[k], rotary_inertia_scale[k]);
    const auto share_out = [&](std::vector<double>& of_node, auto of_element, auto first_share) {
        of_node.assign(static_cast<std::size_t>(n) + 1, 0.0);
        for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k) {
            const double whole = of_element(element[k]), before = first_share(k) * whole;
            of_node[k] += before;
            of_node[k + 1] += whole - before;
        }
        if (closed()) {
            of_node.front() += of_node.back();
            of_node.back() = 0;
        }
    };
    share_out(
        node_mass, [&](const ElementConstants& c) { return spec_.material.density * c.volume; }, share_before);
    share_out(
        node_length, [](const ElementConstants& c) { return c.rest_length; }, [](std::size_t) { return 0.5; });
    with_end_weights(spec_, weighs_masses, [&](std::size_t i, double weight) {
        node_mass[i] *= weight;
        node_length[i] *= weight;
    });

    // The start shape: the frame at s = 0 turned by the curvature of every cell, half cells at both ends.
    const auto start_curvature = [&](long k) {
        if (!shape.start_curvature_profile.empty()) return nth(shape.start_curvature_profile, k);
        return shape.start_curvature ? *shape.start_curvature : kappa0(k);
    };
    // Straight rods that are turned one by one stay as they are: of a million, most of the work.
    const auto bent = [&](const Quaterniond& q, const Vec3d& curvature, double length) {
        return is_no_turn(q) && zero(curvature) ? q : rotation(length * curvature) * q;
    };
    // A cell that is weighted is turned by kappa D_w.
    const auto bent_at_node = [&](const Quaterniond& q, std::size_t i, const Vec3d& curvature, double length) {
        return bent(q, curvature, skein::cell_weight(*this, i) * length);
    };
    Quaterniond q = bent_at_node(frame_, 0, start_curvature(0), 0.5 * element[0].rest_length);
    Vec3d x{0, 0, 0}, sum{0, 0, 0};
    for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k) {
        if (k > 0) {
            const auto cell = static_cast<long>(k) - 1;
            q = bent_at_node(q, k, start_curvature(cell), 1 / voronoi[k - 1].inv_length);
        }
        start_directors_.push_back(q);
        start_offsets_.push_back(x);
        sum += x;
        const Vec3d stretch = shape.rest_strain + Vec3d{0, 0, 1};
        x += element[k].rest_length * (is_no_turn(q) ? stretch : transpose_times(q, stretch));
    }
    start_offsets_.push_back(x);
    centre_offset_ = (1 / static_cast<double>(n + 1)) * (sum + x);
    end_frame_ = bent_at_node(q, element.size(), start_curvature(n - 2), 0.5 * element.back().rest_length);
    if (closed()) {
        const Quaterniond joined = bent(q, start_curvature(n - 1), 1 / voronoi.back().inv_length);
        const double gap = norm(x) / shape.length, misfit = norm(relative_rotation(joined, start_directors_.front()));
        if (gap > 1e-6 || misfit > 1e-6)
            throw InputError(
                fmt::format("{}: the ring '{}' does not close: its ends are {:.3g} of its length apart and turned by "
                            "{:.3g} rad; a circle has the "
                            "curvature 2 pi/length = {:.9g} 1/m",
                            spec_.source, spec_.name, gap, misfit, 2 * pi / shape.length));
        start_offsets_.back() = start_offsets_.front();
    }
}

/// A cell of a rod that is straight at rest has the energy B/(2 D_w) phi^2. A stiffness of B D/D_w makes that of (D/2)
/// q, so that the lengths stay, and with them the share of each element and the pull of bending.
void RodGroup::weigh_cells() {
    cell_weight.clear();
    with_end_weights(spec_, weighs_cells, [&](std::size_t i, double weight) {
        cell_weight.resize(element.size() + 1, 1.0);
        cell_weight[i] = weight;
        VoronoiConstants& cell = i == 0 ? start_wall : i == element.size() ? end_wall : voronoi[i - 1];
        cell.stiffness = (1 / weight) * cell.stiffness;
    });
}

void RodGroup::pack_rods(std::vector<Capsule>* occupied) {
    std::vector<Capsule> none;
    const std::string where = fmt::format("{}: group '{}'", spec_.source, spec_.name);
    if (body_) { // in a capsule about the d3 of its parts
        double lowest = HUGE_VAL, highest = -HUGE_VAL, radius = 0;
        for (const BodyShape::Point& p : body_->point) {
            const Vec3d at = body_->centre + transpose_times(body_->axes, p.place);
            lowest = std::min(lowest, at.z);
            highest = std::max(highest, at.z);
            radius = std::max(radius, std::hypot(at.x, at.y) + p.radius);
        }
        PackedRods packed = pack(spec_.placement.packing, highest - lowest, radius, occupied ? *occupied : none, where);
        for (std::size_t i = 0; i < packed.origins.size(); ++i)
            packed.origins[i] -= lowest * third_director(packed.frames[i]);
        take_packed(std::move(packed));
        return;
    }
    const Shares share(spec_.shape);
    double radius = 0;
    for (std::size_t k = 0; k < share.size(); ++k) radius = std::max(radius, outer_radius(spec_, k, share[k]));
    take_packed(pack(spec_.placement.packing, norm(start_offsets_.back()), radius, occupied ? *occupied : none, where));
}

void RodGroup::take_packed(PackedRods packed) {
    places_ = Places(std::move(packed.origins), std::move(packed.frames));
    packed_fill_ = packed.fill;
    packed_top_ = packed.top;
}

void RodGroup::read_all() {
    if (!places_.waits()) return;
    require_memory_of_rows(*this, count());
    places_.read(0, count());
    refuse_large_turns(*this);
    set_read(places_.corner(), places_.digest(), heterogeneous() ? least_limits_of_rods(*this) : LeastLimits{});
}

void RodGroup::append_capsules(std::int64_t i, std::vector<Capsule>& capsules) const {
    if (heterogeneous()) return single(i).append_capsules(i, capsules);
    if (body_) {
        const Quaterniond axes = start_director(i, 0);
        const Vec3d at = origin(i) + as_turned(i, centre_offset_);
        for (const BodyShape::Part& p : body_->part)
            capsules.push_back({at + transpose_times(axes, p.from), at + transpose_times(axes, p.to), p.cover()});
        return;
    }
    const Shares share(spec_.shape);
    for (std::size_t k = 0; k < share.size(); ++k)
        capsules.push_back({origin(i) + as_turned(i, start_offsets_[k]),
                            origin(i) + as_turned(i, start_offsets_[k + 1]), outer_radius(spec_, k, share[k])});
}

Vec3d RodGroup::pivot() const {
    if (spec_.start != EndKind::free) return start_offsets_.front();
    if (spec_.end != EndKind::free) return start_offsets_.back();
    Vec3d sum{0, 0, 0};
    double mass = 0;
    for (std::size_t i = 0; i < node_mass.size(); ++i) {
        sum += node_mass[i] * start_offsets_[i];
        mass += node_mass[i];
    }
    return (1 / mass) * sum;
}

void RodGroup::join(std::shared_ptr<const AssemblyCopies> copies) {
    copies_ = std::move(copies);
    within_ = places_;
    if (copies_->count() == 1 && copies_->turns.empty() && zero(copies_->origins.front())) return;
    std::vector<Vec3d> origins;
    std::vector<Quaterniond> turns;
    const bool turned = places_.turned() || !copies_->turns.empty();
    for (std::size_t c = 0; c < copies_->origins.size(); ++c)
        for (std::int64_t i = 0; i < within_.count(); ++i) {
            const Quaterniond copy = copies_->turns.empty() ? no_turn : copies_->turns[c];
            origins.push_back(copies_->origins[c] + transpose_times(copy, within_.origin(i)));
            if (turned) turns.push_back((within_.turned() ? within_.turn(i) : frame_) * copy);
        }
    if (turned && !within_.turned()) {
        std::vector<Vec3d> own_origins;
        for (std::int64_t i = 0; i < within_.count(); ++i) own_origins.push_back(within_.origin(i));
        within_ =
            Places(std::move(own_origins), std::vector<Quaterniond>(static_cast<std::size_t>(within_.count()), frame_));
    }
    places_ = Places(std::move(origins), std::move(turns));
    if (turned) frame_ = no_turn;
    work_out_constants();
    corner_ = places_.corner();
}

void RodGroup::start_state_in_assembly(std::int64_t i, std::span<Slot<1>> out) const {
    if (heterogeneous()) return start_state(i, out); // of one copy
    start_state(within_.origin(i), within_.turned() ? within_.turn(i) : no_turn, within_.turned(), out);
}

void RodGroup::start_state(std::int64_t i, std::span<Slot<1>> out) const {
    if (heterogeneous()) return single(i).start_state(i, out);
    start_state(origin(i), turned() ? places_.turn(i) : no_turn, turned(), out);
}

void RodGroup::start_state(const Vec3d& start, const Quaterniond& turn, bool turned, std::span<Slot<1>> out) const {
    const int n = elements();
    const Vec3d turning = spec_.shape.angular_velocity;
    const bool turns = !zero(turning);
    const Vec3d about = turns ? pivot() : Vec3d{0, 0, 0};
    const auto as_turned = [&](const Vec3d& offset) { return turned ? transpose_times(turn, offset) : offset; };
    Quaterniond before = no_turn, q = turn;
    for (int k = 0; k < slots(); ++k) {
        Slot<1>& s = nth(out, k);
        const Vec3d& offset = nth(start_offsets_, k);
        set_lane(s.position, 0, start + as_turned(offset));
        Vec3d velocity = spec_.shape.velocity;
        if (turns) velocity += cross(turning, as_turned(offset - about));
        if (slides(k)) velocity = scale(free_directions(k), velocity);
        set_lane(s.velocity, 0, holds_node(k) ? Vec3d{0, 0, 0} : velocity);
        if (k < n) {
            const Quaterniond& own = nth(start_directors_, k);
            if (k == 0 || !same(own, before)) q = turned ? own * turn : own;
            before = own;
            set_lane(s.director, 0, q);
            Vec3d spin = spec_.shape.element_spin;
            if (turns) spin = q * turning + spin;
            set_lane(s.spin, 0, holds_element(k) ? Vec3d{0, 0, 0} : spin);
        } else {
            set_lane(s.director, 0, no_turn);
            set_lane(s.spin, 0, Vec3d{0, 0, 0});
        }
    }
    apply_hold(*this, out.data());
}

Vec3d RodGroup::magnetisation(std::int64_t i) const {
    if (copies_ && copies_->count() > 1) {
        const Vec3d in_copy = magnetisation_at(within_.origin(i % rods_per_copy()) - within_.corner());
        return copies_->turns.empty() ? in_copy : transpose_times(nth(copies_->turns, copy_of(i)), in_copy);
    }
    return magnetisation_at(origin(i) - corner_);
}

double RodGroup::magnetisation_strength(std::int64_t i) const {
    const double strength = spec_.magnetisation.strength;
    if (!copies_ || copies_->magnetisation.empty()) return strength;
    return strength * nth(copies_->magnetisation, copy_of(i));
}

double RodGroup::largest_magnetisation() const {
    const double strength = spec_.magnetisation.strength;
    if (!copies_ || copies_->magnetisation.empty()) return strength;
    return strength * *std::max_element(copies_->magnetisation.begin(), copies_->magnetisation.end());
}

Vec3d RodGroup::magnetisation_at(const Vec3d& place) const {
    const Magnetisation& m = spec_.magnetisation;
    const double px = m.wavelength_x != 0 ? m.phase + 2 * pi * place.x / m.wavelength_x : 0;
    const double py = m.wavelength_y != 0 ? m.phase + 2 * pi * place.y / m.wavelength_y : 0;
    switch (m.pattern) {
    case MagnetisationPattern::none:
        return {0, 0, 0};
    case MagnetisationPattern::uniform:
        return unit(m.direction);
    case MagnetisationPattern::wave_x:
        return {std::sin(px), 0, std::cos(px)};
    case MagnetisationPattern::wave_xy: {
        // |(sin px, sin py, cos px + cos py)|^2 = 2 + 2 cos px cos py vanishes only where both sines do and the cosines
        // oppose.
        const double length = std::sqrt(2 + 2 * std::cos(px) * std::cos(py) + 1e-12);
        return (1 / length) * Vec3d{std::sin(px), std::sin(py), std::cos(px) + std::cos(py)};
    }
    }
    return {0, 0, 0};
}

} // namespace skein
