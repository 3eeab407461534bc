// Slopes of a contact's forces over its displacement in a step of length h, for implicit steps.           theory.md
// (123)
//   normal      p = dN/dg + c/h at the overlap g + z,  c the dashpot's,  z the zone before bodies touch
//   tangential  memory: q = k_t + c_t/h, whether it sticks or slides
//               spring of regularised or anisotropic friction: q = dT/du_t/h at rest;  published: twice mu N/(v_s h)
// Contacts that slide resist changes of their velocity alone, so that q slows none that is steady. Springs with memory
// are no stiffer than a thousand times the inertia over h^2, but at walls: theory.md (123)
#pragma once

#include "contact/response.hpp"

namespace skein {

/// Share of a contact's slopes in those of each of its bodies by itself, with which steps are stable at any length and
/// stiffness: theory.md (124)
inline constexpr double own_share_of_tangents = 1.5;

/// Mass that springs of friction add to a body in a step at most, over its own.
inline constexpr double most_added_by_friction = 1e3;

/// Slopes of one contact, N/m.
template <class P> struct ContactSlopes { P normal, tangential; };

/// Normal slope at a depth, m: that of the overlap and the zone.
template <class P>
SKEIN_INLINE P normal_slope(ContactNormal normal, const ContactNumbers<P>& law, double h, const P& depth) {
    const P rate(1 / h), zero(0.0);
    if (normal == ContactNormal::linear) return select(depth > zero, fma(rate, law.damping, law.stiffness), zero);
    return sqrt(max(depth, zero)) * fma(rate, law.damping, P(1.5) * law.stiffness);
}

/// Size of the slope by which a normal force turns with the line between both axes, N/m. It pushes bodies away from
/// where they are balanced; a step without it has no bound where N h^2 exceeds m d.
template <class P> SKEIN_INLINE P turning_slope(const P& normal, const ContactState<P>& in) {
    return normal / max(in.distance, P(0.5) * (in.radius_1 + in.radius_2));
}

/// `force`: that of contact_force() with these arguments. `zone`: gap of bodies that have a normal slope before they
/// touch, m.
template <int W> SKEIN_INLINE ContactSlopes<Pack<W>>
contact_slopes(ContactKinds kinds, const ContactNumbers<Pack<W>>& law, const ContactState<Pack<W>>& in, double h,
               const ContactForce<Pack<W>>& force, const ContactWeight<Pack<W>>& weight, Pack<W> elsewhere,
               double zone) {
    using P = Pack<W>;
    const P zero(0.0), rate(1 / h), tiny(1e-300), two(2.0), overlap = in.radius_1 + in.radius_2 - in.distance;
    const P root = kinds.normal == ContactNormal::hertz ? sqrt(max(overlap, zero)) : P(1.0);
    ContactSlopes<P> slopes{weight.normal * normal_slope(kinds.normal, law, h, overlap + P(zone)), zero};
    const P most = law.kinetic_friction * (force.normal + elsewhere);
    if (kinds.friction == ContactFriction::memory)
        slopes.tangential = weight.all * fma(rate, law.tangential_damping,
                                             min(law.tangential_stiffness * root, law.stiffest_tangential));
    else if (has_spring(kinds.friction))
        slopes.tangential = two * most * weight.all /
                            max(fma(weight.all * law.twice_step, law.slip_speed, most * law.compliance), tiny);
    else if (kinds.friction == ContactFriction::published)
        slopes.tangential = two * most * rate / max(law.slip_speed, tiny);
    return {slopes.normal, select(overlap > zero, slopes.tangential, zero)};
}

} // namespace skein
