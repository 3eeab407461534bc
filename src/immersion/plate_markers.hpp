// How a plate that goes from one side of a periodic box to the other stands in the fluid.
#pragma once

#include "immersion/rod_surface.hpp"

namespace skein {

/// By its half thickness, m, alone, however deep the box: two sides, or a sheet where these are too close.
SectionMarkers plate_markers(double half_thickness, double spacing, double retraction);

} // namespace skein
