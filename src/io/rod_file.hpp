// Files of rods (docs/files.md): HDF5 with a dataset for each quantity, or comma-separated values with a header. Each
// rank reads its own blocks.
#pragma once

#include "skein/placement/places.hpp"

#include <memory>
#include <string>

namespace skein {

/// Opens a file and checks its shape, not yet its numbers. Throws InputError. Its text begins with `source`, a line of
/// the scene, if there is no such file, and with the name of a file without rods.
std::shared_ptr<const RodSource> open_rod_file(const std::string& path, const std::string& source);

} // namespace skein
