// Loads of joints on the nodes of their elements, by form, turn and damping.
#pragma once

#include "joints/joint_events.hpp"
#include "joints/joint_law.hpp"
#include "joints/joint_list.hpp"

namespace skein {

/// Constants of a joint.
template <class P> struct JointConstants {
    P share_a, share_before_a, share_b, share_before_b;
    Vec3<P> arm_a, axis_a, arm_b, axis_b;
    Quaternion<P> rest;
    P rest_distance;
};
inline JointConstants<double> constants_of(const Joint& joint) {
    const JointEnd &a = joint.first, &b = joint.second;
    return {a.share, 1 - a.share, b.share, 1 - b.share, a.arm, a.axis, b.arm, b.axis, joint.rest, joint.rest_distance};
}

/// Loads of a joint on its two elements, node by node.
template <class P> struct JointNodeLoads { Vec3<P> force_a, force_a_next, force_b, force_b_next, couple_a, couple_b; };

template <JointTurn Turn, bool Damped, bool Repels, int W>
SKEIN_INLINE JointNodeLoads<Pack<W>> node_loads(const JointLaw& law, const JoinedElement<Pack<W>>& a,
                                                const JoinedElement<Pack<W>>& b, const Quaternion<Pack<W>>& rest,
                                                const Pack<W>& rest_distance) {
    JointLoad<Pack<W>> on_b;
    const JointLoad<Pack<W>> on_a = joint_load<Turn, Damped, Repels, W>(law, a, b, rest, rest_distance, on_b);
    JointNodeLoads<Pack<W>> loads{a.share_before * on_a.force, a.share * on_a.force, b.share_before * on_b.force,
                                  b.share * on_b.force,        on_a.couple,          on_b.couple};
    if constexpr (Repels) {
        const Vec3<Pack<W>> half_a = Pack<W>(0.5) * on_a.push, half_b = Pack<W>(0.5) * on_b.push;
        loads.force_a += half_a;
        loads.force_a_next += half_a;
        loads.force_b += half_b;
        loads.force_b_next += half_b;
    }
    return loads;
}

/// Loads of a joint with a law of its own, node by node. One piece of code for all that call it: it takes a while to
/// compile.
template <JointForm Form, int W>
[[gnu::noinline]] JointNodeLoads<Pack<W>> node_loads(const AxisAt<Pack<W>>& at, const JoinedElement<Pack<W>>& a,
                                                     const JoinedElement<Pack<W>>& b, const Quaternion<Pack<W>>& rest,
                                                     const Pack<W>& length, AxesMemory<Pack<W>> memory,
                                                     JointFigures<Pack<W>>* figures = nullptr) {
    JointLoad<Pack<W>> on_b;
    const JointLoad<Pack<W>> on_a = form_load<Form, W>(at, a, b, rest, length, memory, on_b, figures);
    return {a.share_before * on_a.force, a.share * on_a.force, b.share_before * on_b.force,
            b.share * on_b.force,        on_a.couple,          on_b.couple};
}

/// Calls f.operator()<Form>() for a table with free axes.
template <class F> auto with_form(const JointSpec& spec, F&& f) {
    switch (form_of(spec)) {
    case JointForm::universal:
        return f.template operator()<JointForm::universal>();
    case JointForm::slider:
        return f.template operator()<JointForm::slider>();
    case JointForm::distance:
        return f.template operator()<JointForm::distance>();
    case JointForm::bushing:
        return f.template operator()<JointForm::bushing>();
    case JointForm::ball:
        return f.template operator()<JointForm::ball>();
    default:
        return f.template operator()<JointForm::hinge>();
    }
}

/// Calls f.operator()<Form, Turn>() for a table with events; the turn is that of a joint without a free axis.
template <class F> auto with_event(const JointSpec& spec, F&& f) {
    if (form_of(spec) != JointForm::spring)
        return with_form(spec, [&]<JointForm Form>() { f.template operator()<Form, JointTurn::none>(); });
    switch (turn_of(spec)) {
    case JointTurn::hinge:
        return f.template operator()<JointForm::spring, JointTurn::hinge>();
    case JointTurn::fixed:
        return f.template operator()<JointForm::spring, JointTurn::fixed>();
    case JointTurn::none:
        break;
    }
    return f.template operator()<JointForm::spring, JointTurn::none>();
}

/// Calls f.operator()<Turn, Damped, Repels>() as a table has them.
template <class F> auto with_joint(const JointSpec& spec, F&& f) {
    const auto with_turn = [&]<bool Damped, bool Repels>() {
        switch (turn_of(spec)) {
        case JointTurn::hinge:
            return f.template operator()<JointTurn::hinge, Damped, Repels>();
        case JointTurn::fixed:
            return f.template operator()<JointTurn::fixed, Damped, Repels>();
        case JointTurn::none:
            break;
        }
        return f.template operator()<JointTurn::none, Damped, Repels>();
    };
    const auto with_damping = [&]<bool Repels>() {
        return spec.law.damped() ? with_turn.template operator()<true, Repels>()
                                 : with_turn.template operator()<false, Repels>();
    };
    return spec.law.repulsion > 0 ? with_damping.template operator()<true>()
                                  : with_damping.template operator()<false>();
}

} // namespace skein
