// Forces of a contact, for W pairs at once.                                                                theory.md (53)-(56)
//   n from 1 to 2 at distance d, overlap g = r1 + r2 - d, contact midway in it: arms a1 = (r1 - g/2) n, a2 = -(r2 - g/2) n
//   u = v1 + w1 x a1 - (v2 + w2 x a2),   u_n = u.n,   u_t = u - u_n n
//   linear        N = max(0, k g + c u_n)
//   Hertz         N = max(0, sqrt(g) (k g + c u_n))
//   memory        x <- (x + h u_t) in the tangent plane,  T* = -k_t x - c_t u_t,  k_t = kappa k (linear), kappa k sqrt(g) (Hertz)
//                 T = T* while |T*| <= mu_s N;  else T = mu_k N T*/|T*| and x = -T/k_t
//   regularised   T = -mu_k N u_t/max(|u_t|, v_s)
//   on 1: force -N n + T, couple a1 x T;  on 2: force N n - T, couple -a2 x T
// A contact pushes, whatever its dashpot says. Source: Cundall, Strack 1979 (Geotechnique 29, 47).
// Cost: 150 flop, of which six divisions and roots.
#pragma once

#include "core/vec3.hpp"

namespace skein {

enum class ContactNormal { linear, hertz };
enum class ContactFriction { none, memory, regularised };

struct ContactLaw {
    ContactNormal normal = ContactNormal::hertz;
    double stiffness = 0;          ///< k, N/m or N/m^1.5
    double damping = 0;            ///< c, N s/m or N s/m^1.5
    ContactFriction friction = ContactFriction::none;
    double static_friction = 0;    ///< mu_s
    double kinetic_friction = 0;   ///< mu_k
    double tangential_share = 0.8; ///< kappa
    double tangential_damping = 0; ///< c_t, N s/m
    double slip_speed = 0;         ///< v_s, m/s
};

template <class P> struct ContactState {
    Vec3<P> normal; ///< from 1 to 2
    P distance, radius_1, radius_2;
    Vec3<P> velocity_1, spin_1, velocity_2, spin_2; ///< of the axes beside the contact; lab
};

template <class P> struct ContactForce {
    Vec3<P> on_1;   ///< N; on 2 the opposite
    Vec3<P> moment; ///< n x T, N: the couple on i is arm_i times this
    P arm_1, arm_2; ///< m
    P normal;       ///< N
};

/// `weight`: of the normal force, where a contact has several points; `elsewhere`: normal force of the others, which friction counts
/// too. `spring`: x of the memory, 0 in a new contact; 0 again where nothing touches.
template <int W>
SKEIN_INLINE ContactForce<Pack<W>> contact_force(const ContactLaw& law, const ContactState<Pack<W>>& in, double h, Vec3<Pack<W>>& spring, Pack<W> weight = 1.0,
                                                 Pack<W> elsewhere = 0.0) {
    using P = Pack<W>;
    const P zero(0.0), half(0.5), tiny(1e-300);
    const P overlap = in.radius_1 + in.radius_2 - in.distance, depth = max(overlap, zero);
    const auto touches = overlap > zero;
    ContactForce<P> out;
    out.arm_1 = fnma(half, overlap, in.radius_1);
    out.arm_2 = fnma(half, overlap, in.radius_2);
    const Vec3<P>& n = in.normal;
    const Vec3<P> slip = in.velocity_1 - in.velocity_2 + cross(out.arm_1 * in.spin_1 + out.arm_2 * in.spin_2, n);
    const P approach = dot(slip, n);
    const Vec3<P> tangential = slip - approach * n;
    const P root = law.normal == ContactNormal::hertz ? sqrt(depth) : P(1.0);
    out.normal = select(touches, max(zero, weight * root * fma(P(law.stiffness), depth, P(law.damping) * approach)), zero);
    const P pressed = out.normal + elsewhere;

    const Vec3<P> none{zero, zero, zero};
    Vec3<P> friction = none;
    if (law.friction == ContactFriction::memory) {
        const P stiffness = P(law.tangential_share * law.stiffness) * root;
        const Vec3<P> moved = fma(P(h), tangential, spring), in_plane = moved - dot(moved, n) * n;
        const Vec3<P> trial = -(stiffness * in_plane) - P(law.tangential_damping) * tangential;
        const P size = norm(trial);
        const auto sticks = size <= P(law.static_friction) * pressed;
        const Vec3<P> slides = (P(law.kinetic_friction) * pressed / max(size, tiny)) * trial;
        friction = select(touches, select(sticks, trial, slides), none);
        spring = select(touches, select(sticks, in_plane, -((P(1.0) / max(stiffness, tiny)) * slides)), none);
    } else if (law.friction == ContactFriction::regularised) {
        friction = -((P(law.kinetic_friction) * pressed / max(norm(tangential), P(law.slip_speed))) * tangential);
    }
    out.moment = cross(n, friction);
    out.on_1 = friction - out.normal * n;
    return out;
}

} // namespace skein
