// Law of a contact, normal force and friction, as scenes state it; one law per pair of materials.  theory.md section 18
//   linear    N = max(0, k g + c u_n)
//   Hertz     N = max(0, sqrt(g) (k g + c u_n))
//   friction  contact/response.hpp
// A law may begin softly, so that rods placed into each other part slowly, and its friction later. A restitution e and
// a time t_c may stand for k and c. They hold for bodies of a known effective mass m:
//   linear    e = exp(-2 z acos(z)/sqrt(1 - z^2)),  z = c/(2 sqrt(k m)), as a contact does not pull
//             -ln e = z w t_c,  k = m w^2
//   Hertz     x'' = -max(0, sqrt(x) (x + D x')), x(0) = 0, x'(0) = 1 leaves at -e after T
//             lengths in G = v t_c/T, times in t_c/T; e and t_c depend on the speed v, and are those at the one given
// Source: Schwager, Poeschel 2007 (Granular Matter 9, 465) for the linear law.
#pragma once

#include "skein/core/fields.hpp"
#include "skein/core/pack.hpp"

#include <algorithm>
#include <cassert>
#include <string_view>
#include <vector>

namespace skein {

enum class ContactNormal { linear, hertz };
inline constexpr std::string_view contact_normal_names[] = {"linear", "hertz"};
enum class ContactFriction { none, memory, regularised, published, anisotropic };
inline constexpr std::string_view contact_friction_names[] = {"none", "memory", "regularised", "published",
                                                              "anisotropic"};
/// True of friction that is a function of the speed of slip, below which it vanishes.
inline bool slips_always(ContactFriction friction) {
    return friction != ContactFriction::none && friction != ContactFriction::memory;
}
/// True of friction whose contacts keep a spring from step to step: for memory, or to be stable at any force.
inline bool has_spring(ContactFriction friction) {
    return friction != ContactFriction::none && friction != ContactFriction::published;
}

/// Numbers of the forces of a contact. P: double, or a pack where they differ from pair to pair.
template <class P> struct ContactNumbers {
    P stiffness;            ///< k, N/m or N/m^1.5
    P damping;              ///< c, N s/m or N s/m^1.5
    P static_friction;      ///< mu_s
    P kinetic_friction;     ///< mu_k
    P tangential_stiffness; ///< kappa k
    P tangential_damping;   ///< c_t, N s/m
    P slip_speed;           ///< v_s, m/s
    P compliance{};         ///< 1/k_h of the spring that regularised friction has for its step, m/N: set_spring
    P twice_step{};         ///< 2 h, s: likewise
    P stiffest_tangential{HUGE_VAL}; ///< of springs with memory, N/m: limit_springs
    bool by_mass = false;            ///< stiffnesses and damping are proportional to the effective mass

    /// For a step h, s, of regularised friction on bodies of this mobility, 1/kg (contact_limits.hpp).
    void set_spring(double step, double mobility) {
        compliance = step * step * mobility;
        twice_step = 2 * step;
    }
    /// Springs of friction with memory that add no more than this mass to bodies of this mobility, over their own.
    void limit_springs(double step, double mobility, double most) {
        if (mobility > 0) stiffest_tangential = most / (step * step * mobility);
    }
    /// Copies the numbers to all lanes.
    template <class Q> ContactNumbers<Q> as() const {
        return {stiffness,          damping,    static_friction, kinetic_friction, tangential_stiffness,
                tangential_damping, slip_speed, compliance,      twice_step,       stiffest_tangential};
    }
};

template <int W> SKEIN_INLINE void set_lane(ContactNumbers<Pack<W>>& all, int i, const ContactNumbers<double>& one) {
    all.stiffness.set(i, one.stiffness);
    all.damping.set(i, one.damping);
    all.static_friction.set(i, one.static_friction);
    all.kinetic_friction.set(i, one.kinetic_friction);
    all.tangential_stiffness.set(i, one.tangential_stiffness);
    all.tangential_damping.set(i, one.tangential_damping);
    all.slip_speed.set(i, one.slip_speed);
    all.compliance.set(i, one.compliance);
    all.twice_step.set(i, one.twice_step);
    all.stiffest_tangential.set(i, one.stiffest_tangential);
}

struct ContactLaw {
    ContactNormal normal = ContactNormal::hertz;
    double stiffness =
        0; ///< k, N/m or N/m^1.5; below 0: automatic, which physics/contact/contact_estimate.hpp makes a number
    double accepted_overlap = 0.05; ///< over the diameter, of the contact that bears most; of an automatic stiffness
    double damping = 0;             ///< c, N s/m or N s/m^1.5
    ContactFriction friction = ContactFriction::none;
    double static_friction = 0;   ///< mu_s
    double kinetic_friction = -1; ///< mu_k; below 0: mu_s
    double kinetic_backward = 0,
           kinetic_sideways = 0;   ///< mu_k of anisotropic friction against a rod's tangent and across
    double tangential_share = 0.8; ///< kappa
    double tangential_damping = 0; ///< c_t, N s/m
    double slip_speed = 0;         ///< v_s, m/s
    double soft_until = 0;         ///< s
    double soft_stiffness = 0, soft_damping = 0;
    double friction_from = 0;   ///< s
    double restitution = 0;     ///< e; 0: stiffness and damping as they are
    double collision_time = 0;  ///< t_c, s
    double collision_speed = 0; ///< v, m/s
    bool by_mass = false;       ///< k and c follow from a restitution, and are proportional to the effective mass

    void fields(FieldVisitor& f);

    static constexpr double automatic = -1;
    bool stiffness_is_automatic() const { return stiffness < 0; }
    double kinetic() const { return kinetic_friction < 0 ? static_friction : kinetic_friction; }
    /// A coefficient of anisotropic friction over that forward; 1 of other laws.
    double over_forward(double coefficient) const {
        return friction == ContactFriction::anisotropic ? coefficient / kinetic_friction : 1;
    }
    double largest_kinetic() const { return std::max({kinetic(), kinetic_backward, kinetic_sideways}); }
    /// With k and c for this restitution and time of bodies whose effective mass m1 m2/(m1 + m2) is known, kg. Itself
    /// without.
    ContactLaw resolved(double effective_mass) const;
    /// With a margin on static friction, so that what has slid to its limit sticks there: at rest it may go either way.
    ContactLaw sticking_at_limit() const;
    /// The law at a time: soft or final stiffness, with or without friction; mu_k always a number.
    ContactLaw at(double time) const;
    ContactNumbers<double> numbers() const;

private:
    void normal_fields(FieldVisitor& f);
    void friction_fields(FieldVisitor& f);
};

/// A law per pair of materials; all of one kind of normal force and one kind of friction.
class ContactLaws {
public:
    /// One for all.
    ContactLaws(const ContactLaw& law);
    /// Laws by materials: that of i and j at [i * materials + j], equal to that at [j * materials + i]. Throws where
    /// kinds differ.
    ContactLaws(std::size_t materials, std::vector<ContactLaw> laws);

    std::size_t materials() const { return materials_; }
    /// Law of materials i and j, or of any two where one law holds for all.
    const ContactLaw& between(std::size_t i, std::size_t j) const {
        if (materials_ == 1) return laws_[0];
        assert(i < materials_ && j < materials_);
        return laws_[i * materials_ + j];
    }
    ContactNormal normal() const { return laws_[0].normal; }
    ContactFriction friction() const { return laws_[0].friction; }
    /// True where a contact needs memory: all but elastic ones without friction.
    bool remember() const;
    ContactLaws sticking_at_limit() const;
    /// Numbers of all laws at a time, in their order.
    std::vector<ContactNumbers<double>> numbers(double time) const;

private:
    std::size_t materials_;
    std::vector<ContactLaw> laws_;
};

} // namespace skein
