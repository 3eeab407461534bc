// Markers of a plate that spans a periodic box.
#pragma once

#include "immersion/rod_surface.hpp"

namespace skein {

/// Two sides, or a sheet if these are too close by the half thickness, m. The depth of the box does not matter.
SectionMarkers plate_markers(double half_thickness, double spacing, double retraction);

} // namespace skein
