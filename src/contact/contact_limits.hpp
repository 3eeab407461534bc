// Largest stable step that contacts leave.                                                         theory.md (58)
//   normal     end node of a rod, squeezed between two others of its kind:
//              (sqrt(c^2 + 4 k m) - c)/k with 2 k, 2 c and the reduced mass
//   friction   likewise of the tangential spring, which also turns the element about its axis: 1/m + r^2/J3
//   slip       published friction is a dashpot of 2 mu_k N/v_s where it rises from v_s to 1.5 v_s
//   body       point of its surface that yields most, on a ball of radius r at c:
//              normal    1/m + A, A the largest eigenvalue of [c]x^T J^-1 [c]x
//              friction  at most 1/m + (sqrt(A) + r/sqrt(J_min))^2, exact of a ball about the centre
// A part of a surface may have more contacts than a node. Balls stacked densely, 12 around each, have eigenvalues up to
// (2/m) max(4 k + 8 k_t, 20 k_t). Six contacts at once cover these; a box has four on each face.
#pragma once

#include "contact/response.hpp"
#include "rod/time_limits.hpp"

#include <string>

namespace skein {

/// Mobility of a group's lightest node under contact forces.
struct ContactMobility {
    double normal = 0, tangential = 0; ///< 1/kg
    double diameter = 0;               ///< m
    int element = 0;
    int touching = 4; ///< number of contacts at once
};
ContactMobility contact_mobility(const RodGroup& group);

/// Mobility for the spring of regularised friction, 1/kg: its compliance is h^2 times that of both groups, or of one at
/// a wall. The largest tangential mobility that a slip sees, about any axis, times the number of contacts at once.
double slip_mobility(const RodGroup& group);

/// Effective masses of a restitution, kg: of a whole rod or body, at a wall, and of two that collide. A rod meets a
/// wall with an end, a body with all of its points or with four of them. Two bodies collide with their middles or end
/// by end. Of a group of rods with sizes of their own: their mean.
double body_mass(const RodGroup& group);
double mass_at_wall(const RodGroup& group);
double reduced_mass(const RodGroup& a, const RodGroup& b);

/// Tangent stiffness, N/m, and dashpot, N s/m, of a law at an overlap, m.
double tangent_stiffness(const ContactLaw& law, double overlap);
double tangent_damping(const ContactLaw& law, double overlap);

/// Energy of the normal spring at an overlap, m: k g^2/2, Hertz 2 k g^2.5/5; J. And the overlap that takes up an
/// energy, m.
double energy_at(const ContactLaw& law, double overlap);
double overlap_of_energy(const ContactLaw& law, double energy);
/// A law so many times as stiff: which keys of `given`, [contact] as scenes have it, to change. `law`: what `given` is
/// for these bodies; else it is that of a [[contact_pair]].
struct StifferLaw {
    std::string text, setting; ///< in words, and as KEY=VALUE; the latter empty of a [[contact_pair]]
};
StifferLaw stiffer_law(const ContactLaw& given, const ContactLaw& law, double effective_mass, double times);

/// Limit, s; `touching`: number of contacts at once at one node.
double contact_limit(const ContactMobility& of, const ContactLaw& law, double stiffness, double damping, int touching);

/// Slip speed, m/s, from which on published friction slows slip under a normal force, N, within a step of `dt`, s.
/// Below it slip trembles. `bodies`: 2, or 1 against a wall. 0 of other friction.
double least_slip_speed(const ContactMobility& of, const ContactLaw& law, double force, int bodies, double dt);

/// Time limit of a group under a law at overlaps up to a share of the diameter, as an entry of its plan.
TimeLimit contact_time_limit(const RodGroup& group, const ContactLaw& law, double share);

} // namespace skein
