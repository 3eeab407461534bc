#include "textbook/textbook_rods.hpp"

#include "kernels/physics_passes.hpp"
#include "loads/magnetic_field.hpp"
#include "skein/core/error.hpp"

#include <algorithm>
#include <cmath>

namespace skein::bench {

namespace {

void set(Vectors& v, std::size_t i, const Vec3d& a) {
    v.x[i] = a.x;
    v.y[i] = a.y;
    v.z[i] = a.z;
}
Vec3d get(const Vectors& v, std::size_t i) { return {v.x[i], v.y[i], v.z[i]}; }

} // namespace

TextbookRod::TextbookRod(const RodGroup& group, std::int64_t index, const std::vector<Damping>& damping, double dt)
    : n_(static_cast<std::size_t>(group.elements())), dt_(dt), position_(n_ + 1), velocity_(n_ + 1), force_(n_ + 1),
      decay_(n_ + 1), gain_(n_ + 1), d1_(n_ + 1), d2_(n_ + 1), d3_(n_ + 1), spin_(n_), couple_(n_), turn_(n_),
      edge_(n_), strain_(n_), stress_(n_), internal_force_(n_), angle_(n_), sine_over_angle_(n_),
      versine_over_square_(n_), length_(n_), axial_ratio_(n_), shear_stiffness_(n_), axial_stiffness_(n_),
      rate_transverse_(n_), rate_axial_(n_), impulse_transverse_(n_), impulse_axial_(n_), moment_(n_), skew_(n_ + 1),
      phi_(n_ + 1), tau_(n_ + 1), first_(n_ + 1), second_(n_ + 1), trace_(n_ + 1), cell_angle_(n_ + 1),
      cell_dilatation_(n_ + 1), energy_(n_ + 1), tension_(n_ + 1), cell_length_(n_), share_before_(n_),
      share_after_(n_), bending_(n_), torsion_(n_) {
    std::vector<Slot<1>> start(n_ + 1);
    group.start_state(index, start);
    const KickConstants kick_constants(group, damping_rates(group, damping), dt);
    for (std::size_t i = 0; i <= n_; ++i) {
        set(position_, i, lane(start[i].position, 0));
        set(velocity_, i, lane(start[i].velocity, 0));
        decay_[i] = kick_constants.node[i].decay;
        gain_[i] = kick_constants.node[i].gain;
    }
    const auto set_frame = [&](std::size_t k, const Mat3d& q) {
        set(d1_, k, q.d1);
        set(d2_, k, q.d2);
        set(d3_, k, q.d3);
    };
    set_frame(0, matrix(group.frame()));
    const Vec3d magnetisation = group.spec().magnetisation.strength * group.magnetisation(index);
    for (std::size_t k = 0; k < n_; ++k) {
        const ElementConstants& c = group.element[k];
        set_frame(k + 1, frame(start[k]));
        set(spin_, k, lane(start[k].spin, 0));
        length_[k] = c.rest_length;
        axial_ratio_[k] = c.inertia.z / c.inertia.x;
        shear_stiffness_[k] = c.stiffness.x;
        axial_stiffness_[k] = c.stiffness.z;
        rate_transverse_[k] = kick_constants.element[k].z_stretch.x;
        rate_axial_[k] = kick_constants.element[k].z_stretch.z;
        impulse_transverse_[k] = kick_constants.element[k].impulse.x;
        impulse_axial_[k] = kick_constants.element[k].impulse.z;
        set(moment_, k, c.volume * (group.start_directors()[k] * magnetisation));
    }
    cell_length_[0] = 0.5 * group.element[0].rest_length;
    share_after_[0] = 1;
    bending_[0] = group.start_wall.stiffness.x;
    torsion_[0] = group.start_wall.stiffness.z;
    for (std::size_t k = 1; k < n_; ++k) {
        const VoronoiConstants& v = group.voronoi[k - 1];
        cell_length_[k] = 1 / v.inv_length;
        share_before_[k] = v.share_before;
        share_after_[k] = v.share_after;
        bending_[k] = v.stiffness.x;
        torsion_[k] = v.stiffness.z;
    }
}

void TextbookRod::state(std::span<Slot<1>> out) const {
    for (std::size_t k = 0; k <= n_; ++k) {
        set_lane(out[k].position, 0, get(position_, k));
        set_lane(out[k].velocity, 0, get(velocity_, k));
        set_lane(out[k].director, 0,
                 k < n_ ? quaternion({get(d1_, k + 1), get(d2_, k + 1), get(d3_, k + 1)}) : no_turn);
        set_lane(out[k].spin, 0, k < n_ ? get(spin_, k) : Vec3d{0, 0, 0});
    }
}

std::size_t TextbookRod::bytes() const {
    constexpr std::size_t node_arrays = 3 * 3 + 2, frame_arrays = 3 * 3, element_arrays = 8 * 3 + 12,
                          cell_arrays = 5 * 3 + 5, cell_constants = 5;
    return sizeof *this +
           8 * ((node_arrays + frame_arrays + cell_arrays) * (n_ + 1) + (element_arrays + cell_constants) * n_);
}

TextbookRods::TextbookRods(const RodGroup& group, const GroupPlan& plan, double dt, std::int64_t count,
                           TextbookBuild build)
    : build_(build) {
    const RodSpec& spec = group.spec();
    const auto* load = plan.program.find<pass::ApplyLoad>();
    const bool same_model = gyration_of(group) == Gyration::circular && spec.start == EndKind::clamped &&
                            spec.end == EndKind::free && !spec.ends_slide() && zero(spec.shape.rest_strain) &&
                            zero(spec.shape.rest_curvature) && spec.shape.rest_curvature_profile.empty() &&
                            plan.damping.size() == 1 && plan.damping[0].kind == DampingKind::legacy && load &&
                            load->load.get_if<MagneticField>() && plan.program.size() == 5;
    if (!same_model)
        throw InputError("group '" + group.name() +
                         "' is not what bench/textbook is written for: see textbook_rods.hpp");
    field_ = load->load.as<MagneticField>();
    for (std::int64_t i = 0; i < count; ++i) rods_.emplace_back(group, i, plan.damping, dt);
}

void TextbookRods::advance(std::span<const Step> steps) {
    field_.prepare(steps);
    const auto step_of = build_ == TextbookBuild::vectorised ? &TextbookRod::step<TextbookBuild::vectorised>
                                                             : &TextbookRod::step<TextbookBuild::plain>;
    for (TextbookRod& rod : rods_)
        for (const Step& step : steps) (rod.*step_of)(field_.field[step.slot]);
}

std::size_t TextbookRods::bytes() const {
    std::size_t bytes = 0;
    for (const TextbookRod& rod : rods_) bytes += rod.bytes();
    return bytes;
}

} // namespace skein::bench
