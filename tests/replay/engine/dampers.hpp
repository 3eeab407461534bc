// Dampers of reference files, as published: they multiply rates after the kick and after the constraints. W = 1.
#pragma once

#include "entry.hpp"

#include "skein/tiles/tile.hpp"

#include <memory>

namespace skein::replay {

/// Throws NotBuilt.
std::unique_ptr<TilePass<1>> make_damper(const Entry& entry, const RodGroup& group);

} // namespace skein::replay
