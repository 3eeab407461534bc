// Optional observables (`[output] observables`): angular momentum, curvature, knots, order. Others are neither computed
// nor sent.
#pragma once

#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "skein/rod/rod_group.hpp"

#include <array>
#include <span>
#include <string>
#include <vector>

namespace skein {

struct ObservableSets {
    bool angular_momentum = false; ///< about the origin, kg m^2/s, lab
    bool curvature = false;        ///< inner cells, per rest length: mean weighted by length, and maximum
    bool knots = false;            ///< twist, writhe and link, summed over rods that bend, turns; cost n^2 per rod
    bool order = false;            ///< order of directions from start to end in the x-y plane, over open rods
    bool any() const { return angular_momentum || curvature || knots || order; }
};

/// Names with units, in the order of extra_values.
std::vector<std::string> extra_names(const ObservableSets& sets);

/// Terms of one rod in sums and maxima; zeros for sets that are off.
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

/// Figures of one rod from its synchronised state [n + 1]. theory.md (42)-(44), (74)
ExtraFigures extra_figures(const RodGroup& group, std::span<const Slot<1>> state, const ObservableSets& sets);

/// Values over the rods of all ranks. Any distribution of rods gives the same bits. Collective.
std::vector<double> extra_values(const Communicator& comm, const Threads& threads, std::span<const ExtraFigures> rods,
                                 const ObservableSets& sets);

} // namespace skein
