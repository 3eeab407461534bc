// Files of rods (docs/files.md): HDF5, a dataset per quantity, or comma-separated values with a header. Read in blocks,
// by every rank for itself.
#pragma once

#include "skein/placement/places.hpp"

#include <memory>
#include <string>

namespace skein {

/// Opens the file and looks at its shape, not yet at its numbers. Throws InputError, beginning with `source` (a line of
/// the scene) where there is no such file, and with the file's name where it is none of rods.
std::shared_ptr<const RodSource> open_rod_file(const std::string& path, const std::string& source);

} // namespace skein
