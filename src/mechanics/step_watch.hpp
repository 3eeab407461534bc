// How long the step is against what present strains leave of its limit, and where in a rod they leave least.  theory.md
// (51)
#pragma once

#include "skein/rod/rod_group.hpp"
#include "skein/rod/slot.hpp"

#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// How long the step is, for those who watch its limit.
struct StepWatch {
    static constexpr double near = 0.93; ///< share of the limit beyond which it may be passed in truth
    double dt = 0;                       ///< s; 0: nobody watches
    double stability = 1;                ///< of the scheme, over Verlet's
    bool stops = true;                   ///< a rod is invalid where the step is beyond its limit

    /// Share beyond which strain feeds rods without damping: their modes go round in four steps or fewer
    /// (tests/stress/resonance.cpp).
    static constexpr double feeds = 0.707;
    static constexpr double keeps = 0.35; ///< share at which their energy keeps to a hundredth of the work of loads
    std::vector<char> undamped; ///< by group: nothing takes energy from its modes; empty: of none is that known

    /// (dt over the limit)^2 of a mode over its eigenvalue, s^2.
    double share_squared() const { return 0.25 * dt * dt / (stability * stability); }
    /// dt over the limit of a mode with this eigenvalue, 1/s^2.
    double share(double eigenvalue) const { return std::sqrt(share_squared() * eigenvalue); }
    /// That limit, s.
    double limit(double eigenvalue) const { return 2 * stability / std::sqrt(eigenvalue); }
};

/// Where present strains leave a rod the shortest step.
struct Tightest {
    double eigenvalue = 0; ///< the rod's largest, 1/s^2
    int element = 0;
    std::string_view mode; ///< of limiting_modes
    double dilatation = 1; ///< of the element
};
Tightest tightest(const RodGroup& group, std::span<Slot<1>> state);

/// "element 3: dt = ... s is ... of the limit ... s that its present strains leave (...)".
std::string text_of(const Tightest& at, const StepWatch& watch);

} // namespace skein
