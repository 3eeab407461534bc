// Nodes and elements held inside a rod. theory.md (47)
#pragma once

#include "skein/rod/rod_group.hpp"

namespace skein {

/// Sets the held components of velocities to 0, and rates of elements held about all axes. Slot n of a ring is not a
/// node of its own. Elements held about some axes are bearings (rod/bearing.hpp), but with the published law: its held
/// components of lab angular velocities become 0.
template <int W> void apply_hold(const RodGroup& group, Slot<W>* slot) {
    using P = Pack<W>;
    const auto free_of = [](const std::string& held) {
        const auto is_free = [&](char axis) { return held.find(axis) == std::string::npos ? 1.0 : 0.0; };
        return Vec3d{is_free('x'), is_free('y'), is_free('z')};
    };
    const Hold& hold = group.spec().hold;
    const int n = group.elements(), nodes = group.nodes();
    const Vec3d direction = free_of(hold.directions), axis = free_of(hold.axes);
    for (const long i : hold.nodes) {
        Vec3<P>& v = slot[i < 0 ? nodes + i : i].velocity;
        v = scale(broadcast<W>(direction), v);
    }
    const bool all = axis.x + axis.y + axis.z == 0;
    if (!all && group.law() != Law::elastica) return;
    for (const long k : hold.elements) {
        Slot<W>& s = slot[k < 0 ? n + k : k];
        s.spin = all ? Vec3<P>{P(0.0), P(0.0), P(0.0)}
                     : s.director * scale(broadcast<W>(axis), transpose_times(s.director, s.spin));
    }
}

} // namespace skein
