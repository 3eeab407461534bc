#include "skein/rod/rod_group.hpp"

#include "core/fused.hpp"
#include "core/memory.hpp"
#include "core/share_text.hpp"
#include "placement/packing.hpp"
#include "rod/bearing.hpp"
#include "rod/body_shape.hpp"
#include "rod/cell_turn.hpp"
#include "rod/end_weights.hpp"
#include "rod/held.hpp"
#include "rod/masses.hpp"
#include "rod/own_sizes.hpp"
#include "rod/sections.hpp"
#include "rod/time_limits.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>

namespace skein {

namespace {

using std::numbers::pi;

/// True for a ring without curvatures, which is a circle.
bool is_circle(const Shape& s) {
    return s.closed && zero(s.rest_curvature) && s.rest_curvature_profile.empty() && !s.start_curvature &&
           s.start_curvature_profile.empty();
}

void make_circle(Shape& s) { s.rest_curvature = {2 * pi / s.length, 0, 0}; }

/// The spec with what a scene leaves out: the curvature of a circle; and a body is one element, whose length is twice
/// its reach.
RodSpec completed(RodSpec spec, const BodyShape* body) {
    Shape& s = spec.shape;
    if (body) {
        s.elements = 1;
        s.length = 2 * body->reach;
        spec.material.density = body->mass / body->volume;
        return spec;
    }
    if (is_circle(s)) make_circle(s);
    return spec;
}

} // namespace

RodGroup::RodGroup(const RodSpec& spec, int id, std::int64_t first_gid, const std::string& directory,
                   std::vector<Capsule>* occupied, std::shared_ptr<const RodSource> source)
    : body_(spec.body ? std::make_shared<const BodyShape>(spec) : nullptr), spec_(completed(spec, body_.get())),
      id_(id), first_gid_(first_gid),
      places_(source ? Places(std::move(source), spec.placement.origin, spec.shape.elements, spec.shape.closed)
                     : Places(spec_.placement, spec_.source, directory)) {
    spec_.placement.origins = spec_.placement.tangents = spec_.placement.normals = {}; // places_ has them
    frame_ = turned() ? no_turn : frame_of(spec.placement.tangent, spec.placement.normal);
    compute_constants();
    if (spec_.placement.kind == PlacementKind::packing) pack_rods(occupied);
    if (!places_.from_file()) corner_ = places_.corner();
    if (heterogeneous()) kinds_ = std::make_shared<Kinds>();
    circle_ = is_circle(spec.shape);
}

RodGroup::RodGroup(const RodGroup& group, std::int64_t i)
    : body_(group.body_), spec_(group.spec_), id_(group.id_), first_gid_(group.first_gid_), frame_(group.frame_),
      copies_(group.copies_), within_corner_(group.within_corner_), corner_(group.corner_), caught_(group.caught_) {
    become(group, i);
}

struct RodGroup::Kinds {
    std::mutex mutex;
    std::unordered_map<std::int64_t, std::unique_ptr<const RodGroup>> of;
    std::vector<std::unique_ptr<RodGroup>> spare; ///< given back
};

const RodGroup& RodGroup::kind(std::int64_t i) const {
    if (!heterogeneous()) return *this;
    const std::lock_guard lock(kinds_->mutex);
    std::unique_ptr<const RodGroup>& kept = kinds_->of[i];
    if (!kept) kept = std::make_unique<const RodGroup>(single(i));
    return *kept;
}

void RodGroup::GiveBack::operator()(RodGroup* rod) const {
    std::unique_ptr<RodGroup> one(rod);
    const std::lock_guard lock(kinds->mutex);
    kinds->spare.push_back(std::move(one));
}

RodGroup::Borrowed RodGroup::borrow(std::int64_t i) const {
    std::unique_ptr<RodGroup> one;
    {
        const std::lock_guard lock(kinds_->mutex);
        if (!kinds_->spare.empty()) {
            one = std::move(kinds_->spare.back());
            kinds_->spare.pop_back();
        }
    }
    if (one) one->become(*this, i);
    else one = std::make_unique<RodGroup>(single(i));
    return {one.release(), GiveBack{kinds_.get()}};
}

/// Rods that have been asked for were made of numbers that change.
void RodGroup::forget_kinds() {
    if (heterogeneous()) kinds_ = std::make_shared<Kinds>();
}

void RodGroup::set_read(const Vec3d& corner, std::uint64_t digest, const LeastLimits& limits) {
    corner_ = corner;
    file_digest_ = digest;
    least_limits_ = limits;
    forget_kinds();
}

void RodGroup::use_formulas(std::function<void(RodSpec&)> read) {
    formulas_ = std::make_shared<const std::function<void(RodSpec&)>>(std::move(read));
    forget_kinds();
}

void RodGroup::put_own_sizes(std::int64_t i, RodSpec& own) const {
    put_sizes(places_, spec_, i, own);
    if (circle_ && !places_.columns().nodes) make_circle(own.shape);
    if (formulas_) (*formulas_)(own);
}

void RodGroup::become(const RodGroup& group, std::int64_t i, Part part) {
    group.put_own_sizes(i, spec_);
    single_rod_ = i;
    places_.become(group.places_, i);
    if (copies_) within_.become(group.within_, i % group.rods_per_copy());
    compute_constants(part);
}

int RodGroup::exposed_slots() const { return body_ ? 2 * static_cast<int>(body_->part.size()) : slots(); }

double RodGroup::exposed_radius(int slot) const {
    const std::size_t at = to_index(slot);
    if (body_) return at % 2 ? -1 : body_->part[at / 2].cover();
    return at < element.size() ? element[at].radius : -1;
}

/// Constants of a body: one slot, with the centre of mass and the principal axes.
void RodGroup::compute_body() {
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
    start_.end_frame = frame_;
    start_.directors = {same_bits(body.axes, no_turn) ? frame_ : body.axes * frame_};
    start_.centre = transpose_times(frame_, body.centre);
    start_.offsets = {start_.centre};
}

void RodGroup::compute_constants(Part part) {
    if (body_) return compute_body();
    const ElementShares shares(spec_.shape);
    element.clear();
    element.reserve(shares.size());
    for (std::size_t k = 0; k < shares.size(); ++k) element.push_back(element_constants(spec_, k, shares[k]));
    const Sections sections(spec_, element);
    sections.put_cells(voronoi);
    start_wall = sections.start_wall();
    end_wall = sections.end_wall();
    weigh_cells();
    nodal_density = skein::nodal_density(spec_, sections);
    rotary_inertia_scale = rotary_inertia_scales(*this);
    for (std::size_t k = 0; k < rotary_inertia_scale.size(); ++k)
        scale_rotary_inertia(element[k], rotary_inertia_scale[k]);
    divide_among_nodes(spec_, sections, element, node_mass, node_length);
    if (part == Part::whole) start_.lay_out(*this);
}

/// A cell of a rod that is straight at rest has the energy B/(2 D_w) phi^2. The stiffness B D/D_w gives (D/2) q this
/// value, so that lengths, shares of elements and the pull of bending stay.
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
    double length = norm(start_.offsets.back()), radius = 0, lowest = 0;
    if (body_) {
        const BodyShape::Column column = body_->column();
        length = column.highest - column.lowest;
        radius = column.radius;
        lowest = column.lowest;
    } else {
        const ElementShares shares(spec_.shape);
        for (std::size_t k = 0; k < shares.size(); ++k) radius = std::max(radius, outer_radius(spec_, k, shares[k]));
    }
    PackedRods packed = pack(spec_.placement.packing, length, radius, occupied ? *occupied : none,
                             fmt::format("{}: group '{}'", spec_.source, spec_.name));
    for (std::size_t i = 0; body_ && i < packed.origins.size(); ++i)
        packed.origins[i] -= lowest * third_director(packed.frames[i]);
    places_ = Places(std::move(packed.origins), std::move(packed.frames));
    packed_fill_ = packed.fill;
    packed_top_ = packed.top;
}

void RodGroup::require_memory(std::int64_t rows) const {
    constexpr double little = 1 << 20; // bytes below which no check is worth its time
    const double needed = static_cast<double>(rows) * static_cast<double>(places_.record_bytes());
    if (needed < little) return;
    const double there = free_memory();
    if (!(needed > there)) return;
    throw InputError(fmt::format("{}: file '{}': {} rods (rows) of '{}' need {} of memory, but {} are free",
                                 spec_.source, spec_.placement.file, rows, spec_.name, bytes_text(needed),
                                 bytes_text(there)));
}

namespace {

/// Limits of rods with sizes of their own under another material: they go with the root of inertia over stiffness.
/// Modes of shear have both stiffnesses.
LeastLimits under_material(LeastLimits limits, const Material& was, const Material& now) {
    const auto shear = [](const Material& m) { return m.shear_modulus > 0 ? m.shear_modulus : m.youngs_modulus / 3; };
    const auto softer = [&](double before, double after) {
        return std::sqrt(now.density / was.density * before / after);
    };
    const double axial = softer(was.youngs_modulus, now.youngs_modulus), twist = softer(shear(was), shear(now)),
                 across = softer(was.shear_factor * shear(was), now.shear_factor * shear(now)),
                 lighter = std::min(1.0, std::sqrt(now.rotary_inertia_scale / was.rotary_inertia_scale)),
                 shearing = std::min({axial, twist, across}) * lighter;
    const LeastLimits times = {axial, shearing, shearing, twist};
    for (std::size_t mode = 0; mode < limits.size(); ++mode) limits[mode] *= times[mode];
    return limits;
}

} // namespace

void RodGroup::take_rods_of(const RodGroup& like) {
    places_ = like.places_;
    set_read(like.corner_, like.file_digest_,
             heterogeneous() ? under_material(like.least_limits_, like.spec_.material, spec_.material) : LeastLimits{});
}

void RodGroup::read_all() {
    if (!places_.waits()) return;
    require_memory(count());
    places_.read(0, count());
    refuse_large_turns(*this);
    set_read(places_.corner(), places_.digest(), heterogeneous() ? least_limits_of_rods(*this) : LeastLimits{});
}

void RodGroup::append_capsules(std::int64_t i, std::vector<Capsule>& capsules) const {
    if (heterogeneous()) return borrow(i)->append_capsules(i, capsules);
    if (body_) {
        const Quaterniond axes = start_director(i, 0);
        const Vec3d at = origin(i) + as_turned(i, start_.centre);
        for (const BodyShape::Part& p : body_->part)
            capsules.push_back({at + transpose_times(axes, p.from), at + transpose_times(axes, p.to), p.cover()});
        return;
    }
    const ElementShares shares(spec_.shape);
    for (std::size_t k = 0; k < shares.size(); ++k)
        capsules.push_back({origin(i) + as_turned(i, start_.offsets[k]),
                            origin(i) + as_turned(i, start_.offsets[k + 1]), outer_radius(spec_, k, shares[k])});
}

Vec3d RodGroup::pivot() const {
    if (spec_.start != EndKind::free) return start_.offsets.front();
    if (spec_.end != EndKind::free) return start_.offsets.back();
    Vec3d sum{0, 0, 0};
    double mass = 0;
    for (std::size_t i = 0; i < node_mass.size(); ++i) {
        sum += node_mass[i] * start_.offsets[i];
        mass += node_mass[i];
    }
    return (1 / mass) * sum;
}

void RodGroup::join(std::shared_ptr<const AssemblyCopies> copies) {
    copies_ = std::move(copies);
    forget_kinds();
    within_ = places_;
    within_corner_ = within_.corner();
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
    const bool heterogeneous = within_.heterogeneous();
    const Places sizes = within_;
    if (turned && !within_.turned()) {
        std::vector<Vec3d> own_origins;
        for (std::int64_t i = 0; i < within_.count(); ++i) own_origins.push_back(within_.origin(i));
        within_ = Places(std::move(own_origins), std::vector<Quaterniond>(to_index(within_.count()), frame_));
        if (heterogeneous) within_.take_sizes(sizes, 1);
    }
    places_ = Places(std::move(origins), std::move(turns));
    if (heterogeneous) places_.take_sizes(sizes, copies_->count());
    if (turned) frame_ = no_turn;
    compute_constants();
    corner_ = places_.corner();
}

void RodGroup::start_state_in_assembly(std::int64_t i, std::span<Slot<1>> out) const {
    if (heterogeneous()) return kind(i).start_state_in_assembly(i, out);
    start_state(within_.origin(i), within_.turned() ? within_.turn(i) : no_turn, within_.turned(), out);
}

void RodGroup::start_state(std::int64_t i, std::span<Slot<1>> out) const {
    if (heterogeneous()) return borrow(i)->start_state(i, out);
    start_state(origin(i), turned() ? places_.turn(i) : no_turn, turned(), out);
}

SKEIN_FUSED void RodGroup::start_state(const Vec3d& start, const Quaterniond& turn, bool turned,
                                       std::span<Slot<1>> out) const {
    const int n = elements();
    const Vec3d turning = spec_.shape.angular_velocity;
    const bool turns = !zero(turning);
    const Vec3d about = turns ? pivot() : Vec3d{0, 0, 0};
    const auto as_turned = [&](const Vec3d& offset) { return turned ? transpose_times(turn, offset) : offset; };
    Quaterniond before = no_turn, q = turn;
    for (int k = 0; k < slots(); ++k) {
        Slot<1>& s = nth(out, k);
        const Vec3d& offset = nth(start_.offsets, k);
        set_lane(s.position, 0, start + as_turned(offset));
        Vec3d velocity = spec_.shape.velocity;
        if (turns) velocity += cross(turning, as_turned(offset - about));
        if (slides(k)) velocity = scale(free_directions(k), velocity);
        set_lane(s.velocity, 0, holds_node(k) ? Vec3d{0, 0, 0} : velocity);
        if (k < n) {
            const Quaterniond& own = nth(start_.directors, k);
            if (k == 0 || !same_bits(own, before)) q = turned ? own * turn : own;
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
    for (const Bearing& b : bearings_of(*this)) {
        Slot<1>& s = nth(out, b.element);
        s.spin = rate_on(b, s.director, s.spin, broadcast<1>(nth(element, b.element).inv_inertia));
    }
}

Vec3d RodGroup::magnetisation(std::int64_t i) const {
    if (copies_ && copies_->count() > 1) {
        const Vec3d in_copy = magnetisation_at(within_.origin(i % rods_per_copy()) - within_corner_);
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
        // have opposite signs.
        const double length = std::sqrt(2 + 2 * std::cos(px) * std::cos(py) + 1e-12);
        return (1 / length) * Vec3d{std::sin(px), std::sin(py), std::cos(px) + std::cos(py)};
    }
    }
    return {0, 0, 0};
}

} // namespace skein
