#include "textbook/textbook_rods.hpp"

#include "core/error.hpp"

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
    : n_(static_cast<std::size_t>(group.elements())), dt_(dt), position_(n_ + 1), velocity_(n_ + 1), force_(n_ + 1), decay_(n_ + 1),
      gain_(n_ + 1), d1_(n_ + 1), d2_(n_ + 1), d3_(n_ + 1), spin_(n_), couple_(n_), turn_(n_), edge_(n_), strain_(n_), stress_(n_),
      internal_force_(n_), angle_(n_), sine_over_angle_(n_), versine_over_square_(n_), length_(n_), axial_ratio_(n_),
      shear_stiffness_(n_), axial_stiffness_(n_), rate_transverse_(n_), rate_axial_(n_), impulse_transverse_(n_),
      impulse_axial_(n_), moment_(n_), skew_(n_ + 1), phi_(n_ + 1), tau_(n_ + 1), first_(n_ + 1), second_(n_ + 1), trace_(n_ + 1),
      cell_angle_(n_ + 1), cell_dilatation_(n_ + 1), energy_(n_ + 1), tension_(n_ + 1), cell_length_(n_), share_before_(n_),
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
    const auto set_frame = [&](std::size_t k, const Mat3d& q) { set(d1_, k, q.d1), set(d2_, k, q.d2), set(d3_, k, q.d3); };
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
    bending_[0] = group.element[0].bending.x;
    torsion_[0] = group.element[0].bending.z;
    for (std::size_t k = 1; k < n_; ++k) {
        const VoronoiConstants& v = group.voronoi[k - 1];
        cell_length_[k] = 1 / v.inv_length;
        share_before_[k] = v.share_before;
        share_after_[k] = v.share_after;
        bending_[k] = v.stiffness.x;
        torsion_[k] = v.stiffness.z;
    }
}

void TextbookRod::step(const Vec3d& field) {
    drift(0.5 * dt_);
    strains();
    stresses();
    turns();
    moments();
    forces();
    couples();
    magnetic_couples(field);
    kick();
    drift(0.5 * dt_);
}

// x += h v;  Q <- R(u) Q, u = h (w1, w2, J3/J1 w3);  then Q and w turn about d3 by (1 - J3/J1) h w3.
void TextbookRod::drift(double h) {
    for (std::size_t i = 0; i <= n_; ++i) {
        position_.x[i] += h * velocity_.x[i];
        position_.y[i] += h * velocity_.y[i];
        position_.z[i] += h * velocity_.z[i];
    }
    for (std::size_t k = 0; k < n_; ++k) {
        turn_.x[k] = h * spin_.x[k];
        turn_.y[k] = h * spin_.y[k];
        turn_.z[k] = h * axial_ratio_[k] * spin_.z[k];
    }
    for (std::size_t k = 0; k < n_; ++k)
        angle_[k] = std::sqrt(turn_.x[k] * turn_.x[k] + turn_.y[k] * turn_.y[k] + turn_.z[k] * turn_.z[k]);
    for (std::size_t k = 0; k < n_; ++k) {
        const double t = angle_[k];
        sine_over_angle_[k] = t > 0 ? std::sin(t) / t : 1.0;
        versine_over_square_[k] = t > 0 ? (1 - std::cos(t)) / (t * t) : 0.5;
    }
    // R = 1 - a [u]x + b [u]x^2, row by row
    for (std::size_t k = 0; k < n_; ++k) {
        const double a = sine_over_angle_[k], b = versine_over_square_[k];
        const double ux = turn_.x[k], uy = turn_.y[k], uz = turn_.z[k];
        const double r11 = 1 - b * (uy * uy + uz * uz), r12 = b * ux * uy + a * uz, r13 = b * ux * uz - a * uy;
        const double r21 = b * ux * uy - a * uz, r22 = 1 - b * (ux * ux + uz * uz), r23 = b * uy * uz + a * ux;
        const double r31 = b * ux * uz + a * uy, r32 = b * uy * uz - a * ux, r33 = 1 - b * (ux * ux + uy * uy);
        const std::size_t q = k + 1;
        const double x1 = d1_.x[q], y1 = d1_.y[q], z1 = d1_.z[q];
        const double x2 = d2_.x[q], y2 = d2_.y[q], z2 = d2_.z[q];
        const double x3 = d3_.x[q], y3 = d3_.y[q], z3 = d3_.z[q];
        d1_.x[q] = r11 * x1 + r12 * x2 + r13 * x3;
        d1_.y[q] = r11 * y1 + r12 * y2 + r13 * y3;
        d1_.z[q] = r11 * z1 + r12 * z2 + r13 * z3;
        d2_.x[q] = r21 * x1 + r22 * x2 + r23 * x3;
        d2_.y[q] = r21 * y1 + r22 * y2 + r23 * y3;
        d2_.z[q] = r21 * z1 + r22 * z2 + r23 * z3;
        d3_.x[q] = r31 * x1 + r32 * x2 + r33 * x3;
        d3_.y[q] = r31 * y1 + r32 * y2 + r33 * y3;
        d3_.z[q] = r31 * z1 + r32 * z2 + r33 * z3;
    }
    for (std::size_t k = 0; k < n_; ++k) angle_[k] = (1 - axial_ratio_[k]) * h * spin_.z[k];
    for (std::size_t k = 0; k < n_; ++k) {
        const double sine = std::sin(angle_[k]), cosine = std::cos(angle_[k]);
        const std::size_t q = k + 1;
        const double x1 = d1_.x[q], y1 = d1_.y[q], z1 = d1_.z[q];
        const double x2 = d2_.x[q], y2 = d2_.y[q], z2 = d2_.z[q];
        d1_.x[q] = cosine * x1 + sine * x2;
        d1_.y[q] = cosine * y1 + sine * y2;
        d1_.z[q] = cosine * z1 + sine * z2;
        d2_.x[q] = cosine * x2 - sine * x1;
        d2_.y[q] = cosine * y2 - sine * y1;
        d2_.z[q] = cosine * z2 - sine * z1;
        const double w1 = spin_.x[k], w2 = spin_.y[k];
        spin_.x[k] = cosine * w1 + sine * w2;
        spin_.y[k] = cosine * w2 - sine * w1;
    }
}

// nu = Q dx/l0
void TextbookRod::strains() {
    for (std::size_t k = 0; k < n_; ++k) {
        edge_.x[k] = position_.x[k + 1] - position_.x[k];
        edge_.y[k] = position_.y[k + 1] - position_.y[k];
        edge_.z[k] = position_.z[k + 1] - position_.z[k];
    }
    for (std::size_t k = 0; k < n_; ++k) {
        const std::size_t q = k + 1;
        strain_.x[k] = (d1_.x[q] * edge_.x[k] + d1_.y[q] * edge_.y[k] + d1_.z[q] * edge_.z[k]) / length_[k];
        strain_.y[k] = (d2_.x[q] * edge_.x[k] + d2_.y[q] * edge_.y[k] + d2_.z[q] * edge_.z[k]) / length_[k];
        strain_.z[k] = (d3_.x[q] * edge_.x[k] + d3_.y[q] * edge_.y[k] + d3_.z[q] * edge_.z[k]) / length_[k];
    }
}

// n = (aGA nu_1, aGA nu_2, EA (e - 1)/e)
void TextbookRod::stresses() {
    for (std::size_t k = 0; k < n_; ++k) {
        stress_.x[k] = shear_stiffness_[k] * strain_.x[k];
        stress_.y[k] = shear_stiffness_[k] * strain_.y[k];
        stress_.z[k] = axial_stiffness_[k] * (strain_.z[k] - 1) / strain_.z[k];
    }
}

// phi = log(Q[k] Q[k-1]^T)
void TextbookRod::turns() {
    for (std::size_t k = 0; k < n_; ++k) {
        const std::size_t q = k + 1;
        skew_.x[k] = d2_.x[q] * d3_.x[k] + d2_.y[q] * d3_.y[k] + d2_.z[q] * d3_.z[k] - d3_.x[q] * d2_.x[k] - d3_.y[q] * d2_.y[k] -
                     d3_.z[q] * d2_.z[k];
        skew_.y[k] = d3_.x[q] * d1_.x[k] + d3_.y[q] * d1_.y[k] + d3_.z[q] * d1_.z[k] - d1_.x[q] * d3_.x[k] - d1_.y[q] * d3_.y[k] -
                     d1_.z[q] * d3_.z[k];
        skew_.z[k] = d1_.x[q] * d2_.x[k] + d1_.y[q] * d2_.y[k] + d1_.z[q] * d2_.z[k] - d2_.x[q] * d1_.x[k] - d2_.y[q] * d1_.y[k] -
                     d2_.z[q] * d1_.z[k];
    }
    for (std::size_t k = 0; k < n_; ++k) {
        const std::size_t q = k + 1;
        trace_[k] = d1_.x[q] * d1_.x[k] + d1_.y[q] * d1_.y[k] + d1_.z[q] * d1_.z[k] + d2_.x[q] * d2_.x[k] + d2_.y[q] * d2_.y[k] +
                    d2_.z[q] * d2_.z[k] + d3_.x[q] * d3_.x[k] + d3_.y[q] * d3_.y[k] + d3_.z[q] * d3_.z[k];
    }
    for (std::size_t k = 0; k < n_; ++k) cell_angle_[k] = trace_[k] < 3 ? std::acos(0.5 * (trace_[k] - 1)) : 0.0;
    for (std::size_t k = 0; k < n_; ++k) {
        const double t = cell_angle_[k], factor = t > 0 ? t / (2 * std::sin(t)) : 0.5;
        phi_.x[k] = factor * skew_.x[k];
        phi_.y[k] = factor * skew_.y[k];
        phi_.z[k] = factor * skew_.z[k];
    }
}

// tau = B phi/(D E^3),  n_3 share -(3/4) phi.B phi/(D^2 E^4),  a = phi x tau,  b = g(phi) phi x a
void TextbookRod::moments() {
    cell_dilatation_[0] = strain_.z[0];
    for (std::size_t k = 1; k < n_; ++k) cell_dilatation_[k] = share_before_[k] * strain_.z[k - 1] + share_after_[k] * strain_.z[k];
    for (std::size_t k = 0; k < n_; ++k) {
        const double factor = 1 / (cell_length_[k] * cell_dilatation_[k] * cell_dilatation_[k] * cell_dilatation_[k]);
        tau_.x[k] = bending_[k] * phi_.x[k] * factor;
        tau_.y[k] = bending_[k] * phi_.y[k] * factor;
        tau_.z[k] = torsion_[k] * phi_.z[k] * factor;
    }
    for (std::size_t k = 0; k < n_; ++k) energy_[k] = phi_.x[k] * tau_.x[k] + phi_.y[k] * tau_.y[k] + phi_.z[k] * tau_.z[k];
    for (std::size_t k = 0; k < n_; ++k) tension_[k] = -0.75 * energy_[k] / (cell_length_[k] * cell_dilatation_[k]);
    for (std::size_t k = 0; k < n_; ++k) {
        first_.x[k] = phi_.y[k] * tau_.z[k] - phi_.z[k] * tau_.y[k];
        first_.y[k] = phi_.z[k] * tau_.x[k] - phi_.x[k] * tau_.z[k];
        first_.z[k] = phi_.x[k] * tau_.y[k] - phi_.y[k] * tau_.x[k];
    }
    for (std::size_t k = 0; k < n_; ++k) {
        // Below 1e-4 rad the difference cancels; the series' next term is 1e-10 of the first there.
        const double t = cell_angle_[k], g = t > 1e-4 ? (1 - 0.5 * t / std::tan(0.5 * t)) / (t * t) : 1.0 / 12;
        second_.x[k] = g * (phi_.y[k] * first_.z[k] - phi_.z[k] * first_.y[k]);
        second_.y[k] = g * (phi_.z[k] * first_.x[k] - phi_.x[k] * first_.z[k]);
        second_.z[k] = g * (phi_.x[k] * first_.y[k] - phi_.y[k] * first_.x[k]);
    }
}

// f[k] = Q[k]^T n[k] - Q[k-1]^T n[k-1]
void TextbookRod::forces() {
    for (std::size_t k = 0; k < n_; ++k) stress_.z[k] += tension_[k] + tension_[k + 1];
    for (std::size_t k = 0; k < n_; ++k) {
        const std::size_t q = k + 1;
        internal_force_.x[k] = d1_.x[q] * stress_.x[k] + d2_.x[q] * stress_.y[k] + d3_.x[q] * stress_.z[k];
        internal_force_.y[k] = d1_.y[q] * stress_.x[k] + d2_.y[q] * stress_.y[k] + d3_.y[q] * stress_.z[k];
        internal_force_.z[k] = d1_.z[q] * stress_.x[k] + d2_.z[q] * stress_.y[k] + d3_.z[q] * stress_.z[k];
    }
    set(force_, 0, get(internal_force_, 0));
    for (std::size_t k = 1; k < n_; ++k) {
        force_.x[k] = internal_force_.x[k] - internal_force_.x[k - 1];
        force_.y[k] = internal_force_.y[k] - internal_force_.y[k - 1];
        force_.z[k] = internal_force_.z[k] - internal_force_.z[k - 1];
    }
    set(force_, n_, -get(internal_force_, n_ - 1));
}

// c[k] = l0 nu x n + (tau + a/2 + b) of the cell behind - (tau - a/2 + b) of the cell before
void TextbookRod::couples() {
    for (std::size_t k = 0; k < n_; ++k) {
        couple_.x[k] = length_[k] * (strain_.y[k] * stress_.z[k] - strain_.z[k] * stress_.y[k]);
        couple_.y[k] = length_[k] * (strain_.z[k] * stress_.x[k] - strain_.x[k] * stress_.z[k]);
        couple_.z[k] = length_[k] * (strain_.x[k] * stress_.y[k] - strain_.y[k] * stress_.x[k]);
    }
    for (std::size_t k = 0; k < n_; ++k) {
        couple_.x[k] += tau_.x[k + 1] - tau_.x[k] + 0.5 * (first_.x[k + 1] + first_.x[k]) + second_.x[k + 1] - second_.x[k];
        couple_.y[k] += tau_.y[k + 1] - tau_.y[k] + 0.5 * (first_.y[k + 1] + first_.y[k]) + second_.y[k + 1] - second_.y[k];
        couple_.z[k] += tau_.z[k + 1] - tau_.z[k] + 0.5 * (first_.z[k + 1] + first_.z[k]) + second_.z[k + 1] - second_.z[k];
    }
}

// c[k] += V m x Q b
void TextbookRod::magnetic_couples(const Vec3d& b) {
    for (std::size_t k = 0; k < n_; ++k) {
        const std::size_t q = k + 1;
        const double b1 = d1_.x[q] * b.x + d1_.y[q] * b.y + d1_.z[q] * b.z;
        const double b2 = d2_.x[q] * b.x + d2_.y[q] * b.y + d2_.z[q] * b.z;
        const double b3 = d3_.x[q] * b.x + d3_.y[q] * b.y + d3_.z[q] * b.z;
        couple_.x[k] += moment_.y[k] * b3 - moment_.z[k] * b2;
        couple_.y[k] += moment_.z[k] * b1 - moment_.x[k] * b3;
        couple_.z[k] += moment_.x[k] * b2 - moment_.y[k] * b1;
    }
}

// v <- a v + (h/m) b f;  w_i <- a_i w_i + (h/J_i) b_i c_i by the implicit midpoint, z_i proportional to the dilatation
void TextbookRod::kick() {
    for (std::size_t i = 0; i <= n_; ++i) {
        velocity_.x[i] = decay_[i] * velocity_.x[i] + gain_[i] * force_.x[i];
        velocity_.y[i] = decay_[i] * velocity_.y[i] + gain_[i] * force_.y[i];
        velocity_.z[i] = decay_[i] * velocity_.z[i] + gain_[i] * force_.z[i];
    }
    // Below 1e-4 the difference cancels; the series' next term is 4e-14 there.
    const auto mean_of = [](double z) { return z < 2 ? 2 / (2 + z) : 1 / z; };
    for (std::size_t k = 0; k < n_; ++k) {
        const double z = rate_transverse_[k] * strain_.z[k], decay = std::max(0.0, (2 - z) / (2 + z));
        const double gain = impulse_transverse_[k] * mean_of(z);
        spin_.x[k] = decay * spin_.x[k] + gain * couple_.x[k];
        spin_.y[k] = decay * spin_.y[k] + gain * couple_.y[k];
    }
    for (std::size_t k = 0; k < n_; ++k) {
        const double z = rate_axial_[k] * strain_.z[k], decay = std::max(0.0, (2 - z) / (2 + z));
        spin_.z[k] = decay * spin_.z[k] + impulse_axial_[k] * mean_of(z) * couple_.z[k];
    }
}

void TextbookRod::state(std::span<Slot<1>> out) const {
    for (std::size_t k = 0; k <= n_; ++k) {
        set_lane(out[k].position, 0, get(position_, k));
        set_lane(out[k].velocity, 0, get(velocity_, k));
        set_lane(out[k].director, 0, k < n_ ? quaternion({get(d1_, k + 1), get(d2_, k + 1), get(d3_, k + 1)}) : no_turn);
        set_lane(out[k].spin, 0, k < n_ ? get(spin_, k) : Vec3d{0, 0, 0});
    }
}

std::size_t TextbookRod::bytes() const {
    constexpr std::size_t node_arrays = 3 * 3 + 2, frame_arrays = 3 * 3, element_arrays = 8 * 3 + 12, cell_arrays = 5 * 3 + 5,
                          cell_constants = 5;
    return sizeof *this + 8 * ((node_arrays + frame_arrays + cell_arrays) * (n_ + 1) + (element_arrays + cell_constants) * n_);
}

TextbookRods::TextbookRods(const RodGroup& group, const GroupPlan& plan, double dt, std::int64_t count) {
    const RodSpec& spec = group.spec();
    const auto is_zero = [](const Vec3d& a) { return a.x == 0 && a.y == 0 && a.z == 0; };
    const bool same_model = plan.circular && spec.start == EndKind::clamped && spec.end == EndKind::free &&
                            is_zero(spec.shape.rest_strain) && is_zero(spec.shape.rest_curvature) &&
                            spec.shape.rest_curvature_profile.empty() && plan.damping.size() == 1 &&
                            plan.damping[0].kind == DampingKind::legacy && plan.loads.size() == 1 &&
                            std::holds_alternative<MagneticField>(plan.loads[0]);
    if (!same_model)
        throw InputError("group '" + group.name() + "' is not what bench/textbook is written for: see textbook_rods.hpp");
    field_ = std::get<MagneticField>(plan.loads[0]);
    for (std::int64_t i = 0; i < count; ++i) rods_.emplace_back(group, i, plan.damping, dt);
}

void TextbookRods::visit(std::span<const Step> steps) {
    field_.prepare(steps);
    for (TextbookRod& rod : rods_)
        for (const Step& step : steps) rod.step(field_.field[step.slot]);
}

std::size_t TextbookRods::bytes() const {
    std::size_t bytes = 0;
    for (const TextbookRod& rod : rods_) bytes += rod.bytes();
    return bytes;
}

} // namespace skein::bench
