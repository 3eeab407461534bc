#include "contact/contact_limits.hpp"

#include "rod/rigid.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

ContactMobility rigid_mobility(const RodGroup& group) {
    const ElementConstants& c = group.element[0];
    const double half = 0.5 * c.rest_length, r = c.radius, whole = 1 / element_mass(group);
    const double rises = half * r * c.inv_inertia.x, falls = r * r * (c.inv_inertia.z - c.inv_inertia.x); // a parabola in the sine
    const double sine = rises < falls ? rises / falls : 1, lever = half + r * sine;
    return {whole + half * half * c.inv_inertia.x,
            whole + lever * lever * c.inv_inertia.x + r * r * (1 - sine * sine) * c.inv_inertia.z, 2 * r, 0};
}

} // namespace

ContactMobility contact_mobility(const RodGroup& group) {
    if (is_rigid(group)) return rigid_mobility(group);
    ContactMobility most;
    for (int k = 0; k < group.elements(); ++k) {
        const auto at = static_cast<std::size_t>(k);
        const ElementConstants& c = group.element[at];
        // A ring's last node has no mass: it is its first.
        const double light =
            std::min(group.node_mass[at], group.node_mass[at + 1] > 0 ? group.node_mass[at + 1] : group.node_mass[0]);
        const double tangential = 1 / light + c.radius * c.radius * c.inv_inertia.z;
        if (tangential > most.tangential) most = {1 / light, tangential, most.diameter, k};
        most.diameter = std::max(most.diameter, 2 * c.radius);
    }
    return most;
}

double element_mass(const RodGroup& group) { return group.spec().material.density * group.element[0].volume; }
double mass_at_wall(const RodGroup& group) { return is_rigid(group) ? group.node_mass[0] : element_mass(group); }
double reduced_mass(const RodGroup& a, const RodGroup& b) { return 1 / (1 / element_mass(a) + 1 / element_mass(b)); }

double tangent_stiffness(const ContactLaw& law, double overlap) {
    return law.normal == ContactNormal::linear ? law.stiffness : 1.5 * law.stiffness * std::sqrt(overlap);
}
double tangent_damping(const ContactLaw& law, double overlap) {
    return law.normal == ContactNormal::linear ? law.damping : law.damping * std::sqrt(overlap);
}

double contact_limit(const ContactMobility& of, const ContactLaw& law, double stiffness, double damping, int touching) {
    const auto limit = [&](double k, double c, double mobility) {
        k *= touching, c *= touching;
        const double m = 0.5 / mobility; // two alike
        return k > 0 ? (std::sqrt(c * c + 4 * k * m) - c) / k : HUGE_VAL;
    };
    double dt = limit(stiffness, damping, of.normal);
    if (law.friction == ContactFriction::memory) {
        const double spring =
            law.normal == ContactNormal::linear ? stiffness : stiffness / 1.5; // k_t = kappa k sqrt(g), not its derivative
        dt = std::min(dt, limit(law.tangential_share * spring, law.tangential_damping, of.tangential));
    }
    return dt;
}

TimeLimit contact_time_limit(const RodGroup& group, const ContactLaw& law, double share) {
    const ContactMobility of = contact_mobility(group);
    const double overlap = share * of.diameter;
    return {"contact",
            contact_limit(of, law, tangent_stiffness(law, overlap), tangent_damping(law, overlap), is_rigid(group) ? 6 : 4),
            of.element};
}

} // namespace skein
