// What rods weigh against the fluid in their place, which moves with them and bears its own inertia.       theory.md
// (88), (88a)
#pragma once

#include "immersion/rod_surface.hpp"

#include <span>
#include <vector>

namespace skein {

/// Shares of an inertia of a rod: of one number, or of all three components.
template <class T> struct InertiaShares {
    T borne;    ///< by the fluid
    T felt;     ///< by kicks: what the fluid does not bear, and no less than a quarter of what it does
    T added;    ///< to what the fluid does not bear, for kicks to feel as much
    T returned; ///< in a step of the fluid, of the momentum that this has taken; where less than 1, at a Courant number
                ///< of 0.8
};

/// The fluid moves with a rod where markers make it: that around a ring of them, up to half of the way to the next
/// ones, bears its inertia for the nodes and the element of this ring. About directions from which no marker lies off,
/// it bears nothing.
class InertiaInFluid {
public:
    /// Of a group whose rods have these markers, ring after ring, in a fluid of that density, kg/m^3. `inner`: whether
    /// the fluid within rods bears its own inertia; if not, rods bear all of theirs and it comes on top.
    InertiaInFluid(const RodGroup& group, std::span<const RodMarker> markers, double density, bool inner);

    double displaced;                              ///< mass of fluid in the place of the rod, over the rod's
    std::vector<InertiaShares<double>> of_nodes;   ///< [slots]
    std::vector<InertiaShares<Vec3d>> of_elements; ///< [elements], about d1, d2, d3

    /// Of what kicks feel, anywhere; at most 1.
    double least_effective() const;
};

} // namespace skein
