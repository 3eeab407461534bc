// Inertia of rods and bodies in a fluid, which bears its own in their place and moves with them.
//                                                                        theory.md (88), (88a), (140)-(142)
#pragma once

#include "core/principal_axes.hpp"
#include "skein/rod/rod_group.hpp"

#include <span>
#include <vector>

namespace skein {

struct RodMarker;

/// Shares of an inertia of a rod: of one number, or of all three components.
template <class T> struct InertiaShares {
    T displaced;  ///< beta: inertia that the displaced fluid bears
    T effective;  ///< m_hat/m: inertia that kicks divide by, max(1 - beta, beta/4)
    T added;      ///< m_A/m: effective inertia in excess of 1 - beta
    T relaxation; ///< theta: fraction of the added mass' momentum that a step returns; below 1, at a Courant number of
                  ///< 0.8; above 1, before it is due
};

/// Fluid within a body, which moves with it rigidly; lengths from the centre of mass, along the principal axes.
struct InnerFluid {
    double mass = 0;         ///< kg
    Vec3d centre{0, 0, 0};   ///< m
    SymmetricMatrix inertia; ///< about the centre of mass of the body, kg m^2; 0 about axes that all markers lie on
};

/// Fluid moves with a rod where markers make it. Fluid around a ring of markers, half of the way to the next
/// rings, bears its inertia for the nodes and the element of the ring. It bears none about directions from which no
/// marker of the ring lies off. Fluid within a body moves with it.
class InertiaInFluid {
public:
    /// Inertia of a group whose rods have these markers, ring after ring, in a fluid of that density, kg/m^3. With
    /// `inner` false rods bear all of their inertia, and the inner fluid's comes on top. `sharp`: sharp_shares() of the
    /// surface, empty if it has none. `spans`: rods are plates that span the box along d2.
    InertiaInFluid(const RodGroup& group, std::span<const RodMarker> markers, double density, bool inner,
                   std::span<const double> sharp = {}, bool spans = false);
    /// Inertia of bodies with sharp surfaces.
    InertiaInFluid(const BodyShape& body, double density, bool inner);

    double density_ratio;           ///< density of the fluid over the rod's; displaced over own mass of a body
    InnerFluid inner;               ///< of a body; none of a rod
    Vec3d buoyancy_centre{0, 0, 0}; ///< m, of the volume of a body
    bool sharp = false;             ///< the surface of a body is: it feels the fluid around it too
    std::vector<InertiaShares<double>> of_nodes;   ///< [slots]
    std::vector<InertiaShares<Vec3d>> of_elements; ///< [elements], about d1, d2, d3

    /// Least effective share of any slot, at most 1.
    double least_effective() const;

private:
    void take_body(const BodyShape& body, std::span<const RodMarker> markers, double density, bool has_inner);
};

} // namespace skein
