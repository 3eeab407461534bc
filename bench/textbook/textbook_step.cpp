// The step of the textbook rod, compiled once per TextbookBuild (SKEIN_TEXTBOOK_BUILD) with flags of its own
// (bench/CMakeLists.txt). Nothing of Skein's is called here: what inline functions become under -Ofast must not reach
// the rest of the program.
#include "textbook/textbook_rods.hpp"

#include <algorithm>
#include <cmath>

// Before every loop of the vectorised build: no array overlaps another, so iterations may run side by side.
#ifndef SKEIN_TEXTBOOK_NO_OVERLAP
#define SKEIN_LOOP
#elif defined(__clang__)
#define SKEIN_LOOP _Pragma("clang loop vectorize(assume_safety)")
#else
#define SKEIN_LOOP _Pragma("GCC ivdep")
#endif

namespace skein::bench {

template <TextbookBuild B> void TextbookRod::step(const Vec3d& field) {
    drift<B>(0.5 * dt_);
    strains<B>();
    stresses<B>();
    turns<B>();
    moments<B>();
    forces<B>();
    couples<B>();
    magnetic_couples<B>(field);
    kick<B>();
    drift<B>(0.5 * dt_);
}

// x += h v;  Q <- R(u) Q, u = h (w1, w2, J3/J1 w3);  then Q and w turn about d3 by (1 - J3/J1) h w3.
template <TextbookBuild B> void TextbookRod::drift(double h) {
    SKEIN_LOOP
    for (std::size_t i = 0; i <= n_; ++i) {
        position_.x[i] += h * velocity_.x[i];
        position_.y[i] += h * velocity_.y[i];
        position_.z[i] += h * velocity_.z[i];
    }
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        turn_.x[k] = h * spin_.x[k];
        turn_.y[k] = h * spin_.y[k];
        turn_.z[k] = h * axial_ratio_[k] * spin_.z[k];
    }
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k)
        angle_[k] = std::sqrt(turn_.x[k] * turn_.x[k] + turn_.y[k] * turn_.y[k] + turn_.z[k] * turn_.z[k]);
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        const double t = angle_[k];
        sine_over_angle_[k] = t > 0 ? std::sin(t) / t : 1.0;
        versine_over_square_[k] = t > 0 ? (1 - std::cos(t)) / (t * t) : 0.5;
    }
    // R = 1 - a [u]x + b [u]x^2, row by row
    SKEIN_LOOP
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
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) angle_[k] = (1 - axial_ratio_[k]) * h * spin_.z[k];
    SKEIN_LOOP
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
template <TextbookBuild B> void TextbookRod::strains() {
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        edge_.x[k] = position_.x[k + 1] - position_.x[k];
        edge_.y[k] = position_.y[k + 1] - position_.y[k];
        edge_.z[k] = position_.z[k + 1] - position_.z[k];
    }
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        const std::size_t q = k + 1;
        strain_.x[k] = (d1_.x[q] * edge_.x[k] + d1_.y[q] * edge_.y[k] + d1_.z[q] * edge_.z[k]) / length_[k];
        strain_.y[k] = (d2_.x[q] * edge_.x[k] + d2_.y[q] * edge_.y[k] + d2_.z[q] * edge_.z[k]) / length_[k];
        strain_.z[k] = (d3_.x[q] * edge_.x[k] + d3_.y[q] * edge_.y[k] + d3_.z[q] * edge_.z[k]) / length_[k];
    }
}

// n = (aGA nu_1, aGA nu_2, EA (e - 1)/e)
template <TextbookBuild B> void TextbookRod::stresses() {
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        stress_.x[k] = shear_stiffness_[k] * strain_.x[k];
        stress_.y[k] = shear_stiffness_[k] * strain_.y[k];
        stress_.z[k] = axial_stiffness_[k] * (strain_.z[k] - 1) / strain_.z[k];
    }
}

// phi = log(Q[k] Q[k-1]^T)
template <TextbookBuild B> void TextbookRod::turns() {
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        const std::size_t q = k + 1;
        skew_.x[k] = d2_.x[q] * d3_.x[k] + d2_.y[q] * d3_.y[k] + d2_.z[q] * d3_.z[k] - d3_.x[q] * d2_.x[k] -
                     d3_.y[q] * d2_.y[k] - d3_.z[q] * d2_.z[k];
        skew_.y[k] = d3_.x[q] * d1_.x[k] + d3_.y[q] * d1_.y[k] + d3_.z[q] * d1_.z[k] - d1_.x[q] * d3_.x[k] -
                     d1_.y[q] * d3_.y[k] - d1_.z[q] * d3_.z[k];
        skew_.z[k] = d1_.x[q] * d2_.x[k] + d1_.y[q] * d2_.y[k] + d1_.z[q] * d2_.z[k] - d2_.x[q] * d1_.x[k] -
                     d2_.y[q] * d1_.y[k] - d2_.z[q] * d1_.z[k];
    }
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        const std::size_t q = k + 1;
        trace_[k] = d1_.x[q] * d1_.x[k] + d1_.y[q] * d1_.y[k] + d1_.z[q] * d1_.z[k] + d2_.x[q] * d2_.x[k] +
                    d2_.y[q] * d2_.y[k] + d2_.z[q] * d2_.z[k] + d3_.x[q] * d3_.x[k] + d3_.y[q] * d3_.y[k] +
                    d3_.z[q] * d3_.z[k];
    }
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) cell_angle_[k] = trace_[k] < 3 ? std::acos(0.5 * (trace_[k] - 1)) : 0.0;
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        const double t = cell_angle_[k], factor = t > 0 ? t / (2 * std::sin(t)) : 0.5;
        phi_.x[k] = factor * skew_.x[k];
        phi_.y[k] = factor * skew_.y[k];
        phi_.z[k] = factor * skew_.z[k];
    }
}

// tau = B phi/(D E^3),  n_3 share -(3/4) phi.B phi/(D^2 E^4),  a = phi x tau,  b = g(phi) phi x a
template <TextbookBuild B> void TextbookRod::moments() {
    cell_dilatation_[0] = strain_.z[0];
    SKEIN_LOOP
    for (std::size_t k = 1; k < n_; ++k)
        cell_dilatation_[k] = share_before_[k] * strain_.z[k - 1] + share_after_[k] * strain_.z[k];
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        const double factor = 1 / (cell_length_[k] * cell_dilatation_[k] * cell_dilatation_[k] * cell_dilatation_[k]);
        tau_.x[k] = bending_[k] * phi_.x[k] * factor;
        tau_.y[k] = bending_[k] * phi_.y[k] * factor;
        tau_.z[k] = torsion_[k] * phi_.z[k] * factor;
    }
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k)
        energy_[k] = phi_.x[k] * tau_.x[k] + phi_.y[k] * tau_.y[k] + phi_.z[k] * tau_.z[k];
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) tension_[k] = -0.75 * energy_[k] / (cell_length_[k] * cell_dilatation_[k]);
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        first_.x[k] = phi_.y[k] * tau_.z[k] - phi_.z[k] * tau_.y[k];
        first_.y[k] = phi_.z[k] * tau_.x[k] - phi_.x[k] * tau_.z[k];
        first_.z[k] = phi_.x[k] * tau_.y[k] - phi_.y[k] * tau_.x[k];
    }
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        // Below 1e-4 rad the difference cancels; the series' next term is 1e-10 of the first there.
        const double t = cell_angle_[k], g = t > 1e-4 ? (1 - 0.5 * t / std::tan(0.5 * t)) / (t * t) : 1.0 / 12;
        second_.x[k] = g * (phi_.y[k] * first_.z[k] - phi_.z[k] * first_.y[k]);
        second_.y[k] = g * (phi_.z[k] * first_.x[k] - phi_.x[k] * first_.z[k]);
        second_.z[k] = g * (phi_.x[k] * first_.y[k] - phi_.y[k] * first_.x[k]);
    }
}

// f[k] = Q[k]^T n[k] - Q[k-1]^T n[k-1]
template <TextbookBuild B> void TextbookRod::forces() {
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) stress_.z[k] += tension_[k] + tension_[k + 1];
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        const std::size_t q = k + 1;
        internal_force_.x[k] = d1_.x[q] * stress_.x[k] + d2_.x[q] * stress_.y[k] + d3_.x[q] * stress_.z[k];
        internal_force_.y[k] = d1_.y[q] * stress_.x[k] + d2_.y[q] * stress_.y[k] + d3_.y[q] * stress_.z[k];
        internal_force_.z[k] = d1_.z[q] * stress_.x[k] + d2_.z[q] * stress_.y[k] + d3_.z[q] * stress_.z[k];
    }
    force_.x[0] = internal_force_.x[0];
    force_.y[0] = internal_force_.y[0];
    force_.z[0] = internal_force_.z[0];
    SKEIN_LOOP
    for (std::size_t k = 1; k < n_; ++k) {
        force_.x[k] = internal_force_.x[k] - internal_force_.x[k - 1];
        force_.y[k] = internal_force_.y[k] - internal_force_.y[k - 1];
        force_.z[k] = internal_force_.z[k] - internal_force_.z[k - 1];
    }
    force_.x[n_] = -internal_force_.x[n_ - 1];
    force_.y[n_] = -internal_force_.y[n_ - 1];
    force_.z[n_] = -internal_force_.z[n_ - 1];
}

// c[k] = l0 nu x n + (tau + a/2 + b) of the cell behind - (tau - a/2 + b) of the cell before
template <TextbookBuild B> void TextbookRod::couples() {
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        couple_.x[k] = length_[k] * (strain_.y[k] * stress_.z[k] - strain_.z[k] * stress_.y[k]);
        couple_.y[k] = length_[k] * (strain_.z[k] * stress_.x[k] - strain_.x[k] * stress_.z[k]);
        couple_.z[k] = length_[k] * (strain_.x[k] * stress_.y[k] - strain_.y[k] * stress_.x[k]);
    }
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        couple_.x[k] +=
            tau_.x[k + 1] - tau_.x[k] + 0.5 * (first_.x[k + 1] + first_.x[k]) + second_.x[k + 1] - second_.x[k];
        couple_.y[k] +=
            tau_.y[k + 1] - tau_.y[k] + 0.5 * (first_.y[k + 1] + first_.y[k]) + second_.y[k + 1] - second_.y[k];
        couple_.z[k] +=
            tau_.z[k + 1] - tau_.z[k] + 0.5 * (first_.z[k + 1] + first_.z[k]) + second_.z[k + 1] - second_.z[k];
    }
}

// c[k] += V m x Q b
template <TextbookBuild B> void TextbookRod::magnetic_couples(const Vec3d& b) {
    SKEIN_LOOP
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
template <TextbookBuild B> void TextbookRod::kick() {
    SKEIN_LOOP
    for (std::size_t i = 0; i <= n_; ++i) {
        velocity_.x[i] = decay_[i] * velocity_.x[i] + gain_[i] * force_.x[i];
        velocity_.y[i] = decay_[i] * velocity_.y[i] + gain_[i] * force_.y[i];
        velocity_.z[i] = decay_[i] * velocity_.z[i] + gain_[i] * force_.z[i];
    }
    // Below 1e-4 the difference cancels; the series' next term is 4e-14 there.
    const auto mean_of = [](double z) { return z < 2 ? 2 / (2 + z) : 1 / z; };
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        const double z = rate_transverse_[k] * strain_.z[k], decay = std::max(0.0, (2 - z) / (2 + z));
        const double gain = impulse_transverse_[k] * mean_of(z);
        spin_.x[k] = decay * spin_.x[k] + gain * couple_.x[k];
        spin_.y[k] = decay * spin_.y[k] + gain * couple_.y[k];
    }
    SKEIN_LOOP
    for (std::size_t k = 0; k < n_; ++k) {
        const double z = rate_axial_[k] * strain_.z[k], decay = std::max(0.0, (2 - z) / (2 + z));
        spin_.z[k] = decay * spin_.z[k] + impulse_axial_[k] * mean_of(z) * couple_.z[k];
    }
}

template void TextbookRod::step<TextbookBuild::SKEIN_TEXTBOOK_BUILD>(const Vec3d&);

} // namespace skein::bench
