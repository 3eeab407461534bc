// Observables that a scene asks for by name (`[output] observables`): angular momentum, curvature, knots, order. What
// is not asked for is neither computed nor sent.
#pragma once

#include "parallel/communicator.hpp"
#include "skein/rod/rod_group.hpp"

#include <array>
#include <span>
#include <string>
#include <vector>

namespace skein {

struct ObservableSets {
    bool angular_momentum = false; ///< about the origin, kg m^2/s, lab
    bool curvature = false;        ///< of inner cells, per rest length: mean weighted by length, and maximum
    bool knots = false;            ///< twist, writhe and link, summed over rods that bend, turns; n^2 per rod
    bool order = false;            ///< of directions from start to end in the x-y plane, over rods that have two ends
    bool any() const { return angular_momentum || curvature || knots || order; }
};

/// Names with units, in the order of extra_values.
std::vector<std::string> extra_names(const ObservableSets& sets);

/// What one rod adds to sums and to maxima. Sets that are not asked for leave zeros.
struct ExtraFigures {
    enum Sum {
        angular_x,
        angular_y,
        angular_z,
        bend_length,
        twist_length,
        cell_length,
        twist,
        writhe,
        along_axes,
        cosine,
        sine,
        directed,
        sums
    };
    enum Extreme { bend, twist_rate, extremes };
    std::array<double, sums> sum{};
    std::array<double, extremes> extreme{};
};

/// `state`: one rod at one time (synchronised), [n + 1].                            theory.md (42)-(44), (74)
ExtraFigures extra_figures(const RodGroup& group, std::span<const Slot<1>> state, const ObservableSets& sets);

/// Values over the rods of all ranks, the same bits for any distribution of them. Collective.
std::vector<double> extra_values(const Communicator& comm, std::span<const ExtraFigures> rods,
                                 const ObservableSets& sets);

} // namespace skein
