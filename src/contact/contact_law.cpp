#include "contact/contact_law.hpp"

#include "skein/core/error.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// Restitution of a linear contact that never pulls, by its share of critical damping; -ln e over w t_c is that share
/// too.
double restitution_of_share(double z) {
    if (z < 1) return std::exp(-2 * z * std::acos(z) / std::sqrt(1 - z * z));
    return z > 1 ? std::exp(-2 * z * std::acosh(z) / std::sqrt(z * z - 1)) : std::exp(-2.0);
}

struct Bounce {
    double restitution, time;
};
/// x'' = -max(0, sqrt(x) (x + d x')) from x = 0, x' = 1 until nothing pushes any more. In steps of 1/1000, fourth
/// order: e to 1e-6.
Bounce hertz_bounce(double d) {
    const auto force = [d](double x, double v) { return x > 0 ? std::max(0.0, std::sqrt(x) * (x + d * v)) : 0.0; };
    const double h = 1e-3 / std::max(1.0, d);
    double x = 0, v = 1, t = 0;
    while (x >= 0 && (v > 0 || x + d * v > 0) && t < 1e3) {
        const double a1 = -force(x, v), v2 = v + 0.5 * h * a1, a2 = -force(x + 0.5 * h * v, v2), v3 = v + 0.5 * h * a2,
                     a3 = -force(x + 0.5 * h * v2, v3), v4 = v + h * a3, a4 = -force(x + h * v3, v4);
        x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
        v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
        t += h;
    }
    return {-v, t};
}

/// Argument at which a falling function of a positive number takes a value.
template <class F> double falling_root(F&& f, double value) {
    double low = 0, high = 1;
    while (f(high) > value) {
        low = high;
        high *= 2;
    }
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (f(middle) > value ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

} // namespace

void ContactLaw::fields(FieldVisitor& f) {
    normal_fields(f);
    friction_fields(f);
    f.visit({.name = "soft_until",
             .unit = "s",
             .text = "time until which soft_stiffness and soft_damping replace stiffness and damping",
             .at_least = 0},
            soft_until);
    f.visit({.name = "soft_stiffness", .unit = "N/m, N/m^1.5", .text = "k before soft_until", .at_least = 0},
            soft_stiffness);
    f.visit({.name = "soft_damping", .unit = "N s/m, N s/m^1.5", .text = "c before soft_until", .at_least = 0},
            soft_damping);
    f.visit({.name = "friction_from", .unit = "s", .text = "time at which friction begins", .at_least = 0},
            friction_from);
}

void ContactLaw::normal_fields(FieldVisitor& f) {
    f.choice(
        {.name = "law",
         .unit = "",
         .text = "normal force; linear: k g + c u_n; hertz: sqrt(g) (k g + c u_n); g: overlap, u_n: speed of approach"},
        normal, contact_normal_names);
    f.visit({.name = "stiffness",
             .unit = "N/m, N/m^1.5",
             .text = "k, at least 0; or \"auto\": the most heavily loaded contact overlaps by `accepted_overlap` "
                     "(docs/theory.md 18)",
             .automatic = automatic},
            stiffness);
    f.visit({.name = "accepted_overlap",
             .unit = "-",
             .text = "with stiffness = \"auto\": overlap of the most heavily loaded contact, over the diameter",
             .above = 0,
             .at_most = 0.5},
            accepted_overlap);
    f.visit({.name = "damping",
             .unit = "N s/m, N s/m^1.5",
             .text = "c; with any damping, a contact never pulls",
             .at_least = 0},
            damping);
    f.visit({.name = "restitution",
             .unit = "-",
             .text = "coefficient of restitution for a central collision of two whole rods; with collision_time, it "
                     "replaces stiffness and damping; 0: not used",
             .at_least = 0,
             .at_most = 1},
            restitution);
    f.visit({.name = "collision_time",
             .unit = "s",
             .text = "duration of the collision of two rods, for `restitution`",
             .at_least = 0},
            collision_time);
    f.visit({.name = "collision_speed",
             .unit = "m/s",
             .text = "hertz: speed of approach for `restitution` and `collision_time`",
             .at_least = 0},
            collision_speed);
}

void ContactLaw::friction_fields(FieldVisitor& f) {
    f.choice({.name = "friction",
              .unit = "",
              .text = "memory: a tangential spring that slides at mu N (Cundall, Strack); regularised: mu_k N "
                      "u_t/max(|u_t|, slip_speed); published: none below slip_speed, mu_k N above 1.5 slip_speed; "
                      "anisotropic (walls): regularised, with coefficients forward, backward and sideways"},
             friction, contact_friction_names);
    f.visit(
        {.name = "static_friction", .unit = "-", .text = "memory: mu_s, coefficient of static friction", .at_least = 0},
        static_friction);
    f.visit({.name = "kinetic_friction",
             .unit = "-",
             .text = "mu_k, coefficient of kinetic friction; below 0: equal to static_friction",
             .at_least = -1},
            kinetic_friction);
    f.visit({.name = "kinetic_backward",
             .unit = "-",
             .text = "anisotropic: mu_k for motion against the tangent; kinetic_friction is for motion along it",
             .at_least = 0},
            kinetic_backward);
    f.visit({.name = "kinetic_sideways",
             .unit = "-",
             .text = "anisotropic: mu_k for motion across the tangent",
             .at_least = 0},
            kinetic_sideways);
    f.visit({.name = "tangential_share",
             .unit = "-",
             .text = "memory: ratio of the tangential to the normal stiffness",
             .above = 0},
            tangential_share);
    f.visit({.name = "tangential_damping",
             .unit = "N s/m",
             .text = "memory: damping of the tangential spring",
             .at_least = 0},
            tangential_damping);
    f.visit({.name = "slip_speed",
             .unit = "m/s",
             .text = "regularised, published, anisotropic: speed of the transition from sticking to sliding",
             .at_least = 0},
            slip_speed);
}

ContactLaw ContactLaw::resolved(double effective_mass) const {
    ContactLaw law = *this;
    if (restitution == 0) return law;
    if (!(collision_time > 0)) throw InputError("contact: restitution wants a collision_time, s, above 0");
    if (normal == ContactNormal::hertz && !(collision_speed > 0))
        throw InputError("contact: restitution of the hertz law wants a collision_speed, m/s, above 0");
    law.restitution = 0;
    law.by_mass = true;
    if (normal == ContactNormal::linear) {
        const double z = restitution < 1 ? falling_root(restitution_of_share, restitution) : 0;
        const double z_w_t = z < 1   ? 2 * std::acos(z) / std::sqrt(1 - z * z)
                             : z > 1 ? 2 * std::acosh(z) / std::sqrt(z * z - 1)
                                     : 2.0,
                     w = z_w_t / collision_time;
        law.stiffness = effective_mass * w * w;
        law.damping = 2 * z * effective_mass * w;
    } else {
        const double d =
            restitution < 1 ? falling_root([](double x) { return hertz_bounce(x).restitution; }, restitution) : 0;
        const double time = collision_time / hertz_bounce(d).time, length = collision_speed * time,
                     root = std::sqrt(length);
        law.stiffness = effective_mass / (time * time * root);
        law.damping = d * effective_mass / (time * root);
    }
    return law;
}

ContactLaw ContactLaw::at(double time) const {
    ContactLaw law = *this;
    law.kinetic_friction = kinetic();
    if (time < soft_until) {
        law.stiffness = soft_stiffness;
        law.damping = soft_damping;
        law.by_mass = false;
    }
    if (time < friction_from) law.static_friction = law.kinetic_friction = 0;
    return law;
}

ContactNumbers<double> ContactLaw::numbers() const {
    ContactNumbers<double> numbers{
        stiffness, damping, static_friction, kinetic(), tangential_share * stiffness, tangential_damping, slip_speed};
    numbers.by_mass = by_mass;
    return numbers;
}

ContactLaw ContactLaw::sticking_at_limit() const {
    constexpr double margin = 1e-11; // above the rounding of an overlap
    ContactLaw law = *this;
    law.kinetic_friction = kinetic();
    law.static_friction *= 1 + margin;
    return law;
}

ContactLaws ContactLaws::sticking_at_limit() const {
    ContactLaws all = *this;
    for (ContactLaw& law : all.laws_) law = law.sticking_at_limit();
    return all;
}

ContactLaws::ContactLaws(const ContactLaw& law) : materials_(1), laws_{law} {}

ContactLaws::ContactLaws(std::size_t materials, std::vector<ContactLaw> laws)
    : materials_(materials), laws_(std::move(laws)) {
    if (materials == 0 || laws_.size() != materials * materials)
        throw InputError("contact: one law per pair of materials is wanted");
    for (const ContactLaw& law : laws_)
        if (law.normal != normal() || law.friction != friction())
            throw InputError("contact: all laws of a scene have one kind of normal force and one kind of friction");
}

bool ContactLaws::remember() const {
    return friction() != ContactFriction::none || std::any_of(laws_.begin(), laws_.end(), [](const ContactLaw& law) {
               return law.damping > 0 || law.soft_damping > 0;
           });
}

std::vector<ContactNumbers<double>> ContactLaws::numbers(double time) const {
    std::vector<ContactNumbers<double>> all;
    for (const ContactLaw& law : laws_) all.push_back(law.at(time).numbers());
    return all;
}

} // namespace skein
