// Free tops of a group's elements in the drift, as a choice and as a template argument.
#pragma once

#include "mechanics/drift.hpp"
#include "mechanics/elastica.hpp"

namespace skein {

enum class Gyration {
    circular,
    elliptic_d1,   ///< J1 is the smallest
    elliptic_d2,   ///< J2 is the smallest
    elliptic_each, ///< the smaller axis varies along the rod
    plain          ///< law as published
};
/// Names must differ: groups whose passes have the same names share tiles along.
inline constexpr std::string_view drift_names[] = {"drift (circular)", "drift (elliptic, J1 < J2)",
                                                   "drift (elliptic, J2 < J1)", "drift (elliptic)", "drift (elastica)"};

inline Gyration gyration_of(const RodGroup& group) {
    if (group.law() == Law::elastica) return Gyration::plain;
    if (!group.strained()) {
        const Vec3d& j = group.element[0].inertia;
        return j.x == j.y ? Gyration::circular : j.x < j.y ? Gyration::elliptic_d1 : Gyration::elliptic_d2;
    }
    const Section& s = group.spec().section;
    if (s.kind != SectionKind::circular && !s.profile_2.empty()) return Gyration::elliptic_each;
    if (s.kind == SectionKind::circular || s.radius == s.radius_2) return Gyration::circular;
    // I1 = pi/4 a b^3 is the smaller one where the semi-axis b along d2 is the shorter.
    return s.radius_2 < s.radius ? Gyration::elliptic_d1 : Gyration::elliptic_d2;
}

/// Calls f(Top{}) with the drift of such tops.
template <class F> auto with_gyration(Gyration kind, F&& f) {
    switch (kind) {
    case Gyration::elliptic_d1:
        return f(EllipticGyration<0>{});
    case Gyration::elliptic_d2:
        return f(EllipticGyration<1>{});
    case Gyration::elliptic_each:
        return f(EllipticGyrationOfEach{});
    case Gyration::plain:
        return f(PlainGyration{});
    case Gyration::circular:
        break;
    }
    return f(CircularGyration{});
}

} // namespace skein
