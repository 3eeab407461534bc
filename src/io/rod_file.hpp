// Files of rods (docs/files.md), with a row per rod or with points along rods. Each rank reads its own blocks.
#pragma once

#include "skein/placement/places.hpp"
#include "skein/rod/rod_spec.hpp"

#include <memory>
#include <string>

namespace skein {

/// Opens the file of a group's placement and checks its shape, not yet its numbers. `directory` is that of the scene.
/// Throws InputError. Its text begins with the line of the scene if there is no such file, and with the name of a file
/// that is faulty.
std::shared_ptr<const RodSource> open_rod_file(const std::string& directory, const RodSpec& rods);

} // namespace skein
