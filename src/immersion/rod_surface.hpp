// Markers on the surface of a rod, as its elements carry them.
#pragma once

#include "fluid/fluid_grid.hpp"
#include "skein/core/vec3.hpp"
#include "skein/rod/rod_group.hpp"

#include <cstdint>
#include <vector>

namespace skein {

/// A point that moves with an element: between its nodes, and off the axis along d1 and d2.
struct RodMarker {
    std::uint32_t element;
    double along;          ///< share of the way from the element's first node to its second
    double off_d1, off_d2; ///< m
};

/// How far a section reaches along d1 and d2, m.
struct HalfAxes {
    double along_d1, along_d2;
};
HalfAxes half_axes(const RodGroup& group, std::size_t element);

/// How a section stands in the fluid, by its half axes over the spacing of the grid.
enum class SectionMarkers {
    ring,       ///< equal arcs apart on the surface
    sheet,      ///< along the long axis: the section is flat and too thin for two sides
    centre_line ///< one marker: thinner than a cell, and nearly round
};
SectionMarkers section_markers(const HalfAxes& axes, double spacing, double retraction);

/// Whether rectangular sections go along d2 from one side of a periodic box to the other: a plate without edges there.
bool spans_box(const RodGroup& group, const FluidGrid& grid);

/// Of a rod of the group at rest, ring after ring and about a cell apart, both ends closed; all lie `retraction`, m,
/// within the surface. Order and number are the same for all rods of the group.
std::vector<RodMarker> rod_markers(const RodGroup& group, const FluidGrid& grid, double retraction);

} // namespace skein
