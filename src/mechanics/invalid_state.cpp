#include "mechanics/invalid_state.hpp"

#include "core/rotation.hpp"
#include "rod/time_limits.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace skein {

double most_dilatation(const RodGroup& group) { return std::min(20.0, tension_limit(group)); }

std::optional<InvalidState> find_invalid(const RodGroup& group, std::span<const Slot<1>> state) {
    const auto finite = [](const Vec3d& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); };
    char text[160];
    for (int k = 0; k < group.slots(); ++k) {
        const Slot<1>& s = nth(state, k);
        const char* quantity = !finite(lane(s.position, 0))                     ? "position"
                               : !finite(lane(s.velocity, 0))                   ? "velocity"
                               : !std::isfinite(dot(s.director, s.director)[0]) ? "director"
                               : !finite(lane(s.spin, 0))                       ? "angular velocity"
                                                                                : nullptr;
        if (quantity) {
            std::snprintf(text, sizeof text, "element %d: %s is not finite", k, quantity);
            return InvalidState{k, false, text};
        }
    }
    if (!group.strained()) return std::nullopt;
    for (int k = 0; k < group.elements(); ++k) {
        const Slot<1>&s = nth(state, k), &next = state[to_index(k) + 1];
        const double e = nth(group.element, k).inv_rest_length *
                         dot(lane(third_director(s.director), 0), lane(next.position, 0) - lane(s.position, 0));
        if (!(e > least_dilatation && e < most_dilatation(group))) {
            std::snprintf(text, sizeof text, "element %d: dilatation e = %.4g left [%g, %g]", k, e, least_dilatation,
                          most_dilatation(group));
            return InvalidState{k, true, text};
        }
        if (k == group.cells()) break;
        const int after = (k + 1) % group.elements();
        if (!(std::abs(dot(s.director, nth(state, after).director)[0]) > least_half_cosine)) {
            std::snprintf(text, sizeof text, "elements %d and %d: turned against each other by more than 3 rad", k,
                          after);
            return InvalidState{k, true, text};
        }
    }
    return std::nullopt;
}

namespace {

struct Stretched {
    double dilatation = 0;
    int element = 0;
};

/// Largest dilatation by the distance of nodes, because directors may have turned away from it.
Stretched most_stretched(const RodGroup& group, std::span<const Slot<1>> state) {
    Stretched most;
    for (int k = 0; k < group.elements(); ++k) {
        const std::size_t at = to_index(k);
        const double e =
            group.element[at].inv_rest_length * norm(lane(state[at + 1].position, 0) - lane(state[at].position, 0));
        if (e > most.dilatation) most = {e, k};
    }
    return most;
}

} // namespace

std::string law_hint(const RodGroup& group, std::span<const Slot<1>> state) {
    constexpr double near = 0.4; // share of the largest pull: e = 1.67 e0
    if (!group.strained() || group.law() != Law::incompressible) return {};
    const Stretched most = most_stretched(group, state);
    const ElementConstants& c = nth(group.element, most.element);
    const double share = 1 - c.rest_stretch / most.dilatation;
    if (!(share > near)) return {};
    char text[320];
    std::snprintf(
        text, sizeof text,
        "\n  the law \"incompressible\" supports a pull of at most E A = %.4g N: element %d is stretched to e = "
        "%.4g, by %.2g of "
        "it; a weaker load, a larger radius or youngs_modulus, or the law \"neo_hookean\" would do",
        c.stiffness.z, most.element, most.dilatation, share);
    return text;
}

std::string tension_hint(const RodGroup& group, std::span<const Slot<1>> state) {
    if (!group.strained()) return {};
    const double limit = tension_limit(group);
    const auto [most, element] = most_stretched(group, state);
    char text[160] = "";
    if (most > limit)
        std::snprintf(text, sizeof text, "; tension instability of element %d: e = %.4g, limit e_c = %.4g", element,
                      most, limit);
    return text;
}

} // namespace skein
