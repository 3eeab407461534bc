// Ratio of the step to its limit at present strains, and the place in a rod where it is largest. theory.md (51)
#pragma once

#include "rod/body_shape.hpp"
#include "skein/rod/rod_group.hpp"
#include "skein/rod/slot.hpp"

#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Length of the step, for the check against its limit.
struct StepWatch {
    static constexpr double near = 0.93; ///< ratio to the limit from which on the true limit may be exceeded
    double dt = 0;                       ///< s; 0: no check
    double stability = 1;                ///< stability of the scheme, over Verlet's
    bool stops = true;                   ///< true makes a rod invalid where the step is beyond its limit

    /// Ratio beyond which strain feeds rods without damping: their modes take four steps or fewer per period
    /// (tests/stress/resonance.cpp).
    static constexpr double feeds = 0.707;
    static constexpr double keeps = 0.35; ///< ratio at which their energy keeps to a hundredth of the work of loads
    std::vector<char> undamped;           ///< by group: true where nothing damps its modes; empty where unknown

    static constexpr double most_turn = 3; ///< of a body within a step, rad: beyond it none knows which way it turns
    std::vector<char> acted_on;            ///< by group: true of bodies that something touches or holds
    /// Speed at which a body moves by its own size within a step, m/s.
    double most_speed(const RodGroup& body) const { return 2 * body.body()->reach / dt; }
    double most_spin() const { return most_turn / dt; }
    bool restrains(const RodGroup& group) const;

    /// (dt over the limit)^2 of a mode over its eigenvalue, s^2.
    double share_squared() const { return 0.25 * dt * dt / (stability * stability); }
    /// dt over the limit of a mode with this eigenvalue, 1/s^2.
    double share(double eigenvalue) const { return std::sqrt(share_squared() * eigenvalue); }
    /// Limit of the step for a mode with this eigenvalue, s.
    double limit(double eigenvalue) const { return 2 * stability / std::sqrt(eigenvalue); }
};

/// Motion of a body that its step does not resolve, in words: it would pass through what touches it, or turn any way
/// round; empty: the step resolves it.
std::string unresolved_motion(const RodGroup& group, std::span<const Slot<1>> state, const StepWatch& watch);

/// Place in a rod with the shortest limit at present strains.
struct Tightest {
    double eigenvalue = 0; ///< largest eigenvalue of the rod, 1/s^2
    int element = 0;
    std::string_view mode; ///< one of limiting_modes
    double dilatation = 1; ///< dilatation of the element
};
Tightest tightest(const RodGroup& group, std::span<Slot<1>> state);

/// "element 3: dt = ... s is ... of the limit ... s that its present strains leave (...)".
std::string text_of(const Tightest& at, const StepWatch& watch);

} // namespace skein
