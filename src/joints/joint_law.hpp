// Law of a joint between two elements, W at a time.                                              theory.md (69)-(72)
//   point   x = (1 - s) x_k + s x_{k+1} + r,  r = Q^T a;  v = (1 - s) v_k + s v_{k+1} + w x r;  d = x2 - x1
//   spring  F = k d + nu u,  u = v2 - v1 - (w1 + w2) x d/2                  on 1, -F on 2, both midway between the
//   points hinge   T = k_t n1 x n2 + nu_t (1 - n1 n1^T) (w2 - w1)                  on 1, -T on 2 fixed   T = k_t Q2^T
//   phi + nu_t (w2 - w1),  phi = log(Q2 (C Q1)^T)      on 1, -T on 2 push    R = -k_r (D - |c|)^1.5 c/|c|,  c between
//   the elements' centres  on 1 while |c| < D, -R on 2
// Forces and moments of both sides cancel. Springs have the energies k d^2/2, k_t |n1 - n2|^2/2, k_t phi^2/2 and
// 2/5 k_r (D - |c|)^2.5. Dashpots only take, as F acts where u is measured.
#pragma once

#include "core/rotation.hpp"
#include "joints/joint_spec.hpp"
#include "skein/core/pack.hpp"

namespace skein {

/// State of an element of a joint, and the joint's point in it.
template <class P> struct JoinedElement {
    Vec3<P> node, next;              ///< m
    Vec3<P> velocity, next_velocity; ///< m/s; read where the joint is damped
    Quaternion<P> director;
    Vec3<P> spin;          ///< body, rad/s; read where the joint is damped
    P share, share_before; ///< shares of the next node and of the node in the point
    Vec3<P> arm, axis;     ///< body
};

/// Loads on an element of a joint.
template <class P> struct JointLoad {
    Vec3<P> force;  ///< at the point, lab, N
    Vec3<P> push;   ///< at the centre, lab, N
    Vec3<P> couple; ///< body, N m
};

enum class JointTurn { none, hinge, fixed };
inline JointTurn turn_of(const JointSpec& spec) {
    if (!spec.law.turns() || spec.kind == JointKind::spherical || spec.kind == JointKind::side_by_side)
        return JointTurn::none;
    return spec.kind == JointKind::fixed || spec.kind == JointKind::slider ? JointTurn::fixed : JointTurn::hinge;
}

/// Joints with free axes (joints/axis_law.hpp), ball: spherical ones; spring: all others.
enum class JointForm { spring, hinge, universal, slider, distance, bushing, ball };
inline JointForm form_of(const JointSpec& spec) {
    switch (spec.kind) {
    case JointKind::hinge:
        return spec.axis_law.any() ? JointForm::hinge : JointForm::spring;
    case JointKind::spherical:
        return spec.has_axes() ? JointForm::ball : JointForm::spring;
    case JointKind::universal:
        return JointForm::universal;
    case JointKind::slider:
        return JointForm::slider;
    case JointKind::distance:
        return JointForm::distance;
    case JointKind::bushing:
        return JointForm::bushing;
    default:
        return JointForm::spring;
    }
}

/// Energy of its springs, J; and how far its points are apart, m.
template <class P> struct JointFigures { P energy, gap; };

namespace detail {
template <class P> SKEIN_INLINE Vec3<P> between(P before, P after, const Vec3<P>& a, const Vec3<P>& b) {
    return before * a + after * b;
}
} // namespace detail

/// Returns the loads on the first element; those on the second go to `other`. With `Figures` energies are worked out
/// too.
template <JointTurn Turn, bool Damped, bool Repels, int W>
SKEIN_INLINE JointLoad<Pack<W>> joint_load(const JointLaw& law, const JoinedElement<Pack<W>>& a,
                                           const JoinedElement<Pack<W>>& b, const Quaternion<Pack<W>>& rest,
                                           const Pack<W>& rest_distance, JointLoad<Pack<W>>& other,
                                           JointFigures<Pack<W>>* figures = nullptr) {
    using P = Pack<W>;
    using detail::between;
    const P half(0.5);
    const Vec3<P> ra = transpose_times(a.director, a.arm), rb = transpose_times(b.director, b.arm);
    const Vec3<P> apart = (between(b.share_before, b.share, b.node, b.next) + rb) -
                          (between(a.share_before, a.share, a.node, a.next) + ra);
    const Vec3<P> to_middle = half * apart;
    Vec3<P> force = P(law.stiffness) * apart, wa{}, wb{};
    if constexpr (Damped) {
        wa = transpose_times(a.director, a.spin);
        wb = transpose_times(b.director, b.spin);
        const Vec3<P> va = between(a.share_before, a.share, a.velocity, a.next_velocity) + cross(wa, ra),
                      vb = between(b.share_before, b.share, b.velocity, b.next_velocity) + cross(wb, rb);
        force += P(law.damping) * ((vb - va) - cross(wa + wb, to_middle));
    }
    Vec3<P> on_a = cross(ra + to_middle, force), on_b = cross(rb - to_middle, force);
    P energy(0.0);
    if constexpr (Turn == JointTurn::hinge) {
        const Vec3<P> na = transpose_times(a.director, a.axis), nb = transpose_times(b.director, b.axis);
        Vec3<P> couple = P(law.torsional_stiffness) * cross(na, nb);
        if constexpr (Damped) {
            const Vec3<P> w = wb - wa;
            couple += P(law.torsional_damping) * (w - dot(w, na) * na);
        }
        on_a += couple;
        on_b += couple;
        if (figures) energy += P(0.5 * law.torsional_stiffness) * dot(nb - na, nb - na);
    }
    if constexpr (Turn == JointTurn::fixed) {
        const Vec3<P> phi = relative_rotation_and_jacobian(b.director, rest * a.director).log;
        Vec3<P> couple = P(law.torsional_stiffness) * transpose_times(b.director, phi);
        if constexpr (Damped) couple += P(law.torsional_damping) * (wb - wa);
        on_a += couple;
        on_b += couple;
        if (figures) energy += P(0.5 * law.torsional_stiffness) * dot(phi, phi);
    }
    JointLoad<P> load{force, {}, a.director * on_a};
    other = {-force, {}, b.director * (-on_b)};
    if constexpr (Repels) {
        const Vec3<P> c = half * ((b.node + b.next) - (a.node + a.next));
        const P squared = dot(c, c);
        if (any(squared < rest_distance * rest_distance)) { // else not even a root
            const P distance = sqrt(squared), closer = max(rest_distance - distance, P(0.0)), root = sqrt(closer);
            const Vec3<P> push = (P(law.repulsion) * (closer * root) / max(distance, P(1e-150))) * c;
            load.push = -push;
            other.push = push;
            if (figures) energy += P(0.4 * law.repulsion) * (closer * closer * root);
        }
    }
    if (figures) *figures = {energy + P(0.5 * law.stiffness) * dot(apart, apart), sqrt(dot(apart, apart))};
    return load;
}

} // namespace skein
