// Joints that are made, come to an end or break during a run.                                       theory.md (73i)
//   made     at `from`: where the two sides are then, free of strain; at the start as the scene places them
//   ended    at `until`, or where the joint carries more than `break_force`; it never comes back
#pragma once

#include "joints/axis_law.hpp"

#include <array>
#include <bit>

namespace skein {

/// Places, directions and rest of a joint.
template <class P> struct JointRest {
    Vec3<P> arm_a, axis_a, arm_b, axis_b;
    Quaternion<P> rest;
    P length;
};

/// Memory of a joint from step to step; all zero before its first. That of free axes besides the first follows it.
template <class P> struct JointMemory {
    AxisMemory<P> axis;
    P state;           ///< 0: not made yet; 1: made; 2: ended
    JointRest<P> made; ///< where it has been made, of tables with events
};

/// Lane by lane a or b, of structures that hold nothing but packs.
template <int W, class T> SKEIN_INLINE T select_packs(const Mask<W>& which, const T& a, const T& b) {
    using Packs = std::array<Pack<W>, sizeof(T) / sizeof(Pack<W>)>;
    const auto of_a = std::bit_cast<Packs>(a), of_b = std::bit_cast<Packs>(b);
    Packs out;
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = select(which, of_a[i], of_b[i]);
    return std::bit_cast<T>(out);
}

/// True where joints of a table have such a memory.
inline bool remembers(const JointSpec& spec) { return form_of(spec) != JointForm::spring || spec.events.any(); }
/// Numbers of the memory of one.
inline constexpr std::size_t base_memory_numbers = sizeof(JointMemory<double>) / sizeof(double);
inline std::size_t memory_numbers(const JointSpec& spec) {
    return remembers(spec) ? base_memory_numbers + more_memory_numbers(spec) : 0;
}
/// That memory of free axes, of the packs of a joint; `more`: numbers besides the first axis.
template <class P> SKEIN_INLINE AxesMemory<P> axes_memory(P* memory, std::size_t more) {
    return {reinterpret_cast<JointMemory<P>*>(memory)->axis, more > 0 ? memory + base_memory_numbers : nullptr};
}

/// An element when its step began. Places are those of the middle of a step, half a step beyond the rates that led
/// there.
template <int W> SKEIN_INLINE JoinedElement<Pack<W>> half_a_step_before(JoinedElement<Pack<W>> e, double h) {
    const Pack<W> back(-0.5 * h);
    e.node += back * e.velocity;
    e.next += back * e.next_velocity;
    e.director = rotation(back * e.spin) * e.director;
    return e;
}

/// The joint of two elements as they are, of which the constants of the start are given.
template <JointForm Form, int W>
SKEIN_INLINE JointRest<Pack<W>> made_here(const JoinedElement<Pack<W>>& a, const JoinedElement<Pack<W>>& b,
                                          bool length_is_given, const Pack<W>& length) {
    using P = Pack<W>;
    const P half(0.5);
    const Vec3<P> base_a = detail::between(a.share_before, a.share, a.node, a.next),
                  base_b = detail::between(b.share_before, b.share, b.node, b.next);
    const Vec3<P> place_a = base_a + transpose_times(a.director, a.arm),
                  place_b = base_b + transpose_times(b.director, b.arm), middle = half * (place_a + place_b);
    JointRest<P> made{a.director * (middle - base_a),   a.axis, b.director * (middle - base_b), b.axis,
                      b.director * inverse(a.director), length};
    const Vec3<P> n = transpose_times(a.director, a.axis);
    if constexpr (Form == JointForm::distance) {
        made.arm_a = a.arm;
        made.arm_b = b.arm;
        const Vec3<P> d = place_b - place_a;
        if (!length_is_given) made.length = sqrt(dot(d, d));
    } else if constexpr (Form == JointForm::universal) {
        const Vec3<P> m = transpose_times(b.director, b.axis), across = m - dot(m, n) * n;
        made.axis_b = b.director * ((P(1.0) / max(sqrt(dot(across, across)), P(1e-150))) * across);
    } else if constexpr (Form == JointForm::ball) { // both directions are of the first
    } else {
        made.axis_b = b.director * n;
        const Vec3<P> c = half * ((b.node + b.next) - (a.node + a.next));
        made.length = sqrt(dot(c, c));
    }
    return made;
}

} // namespace skein
