// Markers on the surface of a rod or body, which its elements carry.
#pragma once

#include "fluid/fluid_grid.hpp"
#include "immersion/swept_surface.hpp"
#include "skein/core/vec3.hpp"
#include "skein/rod/rod_group.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

/// Point that moves with an element, between its nodes and off the axis along d1 and d2, or with a body, off its centre
/// of mass.
struct RodMarker {
    std::uint32_t element; ///< 0 of a body
    double along;          ///< share of the way from the element's first node to its second; 0 of a body
    double off_d1, off_d2; ///< m
    double off_d3 = 0;     ///< m, of a body
    double share = 1;      ///< of the action there, whose rest a sharp surface has
};

/// Half axes of a section along d1 and d2, m.
struct HalfAxes {
    double along_d1, along_d2;
};
HalfAxes half_axes(const RodGroup& group, std::size_t element);

/// Arrangement of a section's markers, chosen by its half axes over the spacing of the grid.
enum class SectionMarkers {
    ring,       ///< markers at equal arcs on the surface
    sheet,      ///< markers along the long axis of a section too thin for two sides
    centre_line ///< one marker for a nearly round section thinner than a cell
};
SectionMarkers section_markers(const HalfAxes& axes, double spacing, double retraction);

/// True if rectangular sections span a periodic box along d2, as those of a plate without edges there.
bool spans_box(const RodGroup& group, const FluidGrid& grid);

/// Half thicknesses, in cells: of the thickest part of a rod whose surface is sharp, at least; from which on all of the
/// action of a part is the surface's; and below which all of it is that of markers.
inline constexpr double thick_for_sharp = 1, all_sharp = 0.5, thin_for_sharp = 0.25;
/// Shares of a rod's action on the fluid, at nodes, that its surface has if it is sharp; markers have the rest. Empty
/// if the rod is too thin. theory.md (158)
std::vector<double> sharp_shares(const RodGroup& group, const FluidGrid& grid);

/// Surface of a rod of the group, sharp to these shares.
SweptSurface swept_surface(const RodGroup& group, const FluidGrid& grid, std::vector<double> sharp);

/// Markers of a rod of the group at rest, about a cell apart, ring after ring, with both ends closed. They lie
/// `retraction` [m] within the surface, and nowhere where these shares of it, at nodes, are sharp. All rods of the
/// group have the same number in the same order. A group of bodies has body_markers().
std::vector<RodMarker> rod_markers(const RodGroup& group, const FluidGrid& grid, double retraction,
                                   std::span<const double> sharp = {});

} // namespace skein
