// Loads of reference files as passes. Where src/loads has the same formula it is taken; what differs in the published
// code (shares by number instead of by length, tables) or exists for one file only (moments per element) is here. W
// = 1.
#pragma once

#include "entry.hpp"

#include "loads/load_pass.hpp"
#include "skein/tiles/tile.hpp"

#include <memory>

namespace skein::replay {

/// The pass of an entry of `forces_in_order`. Throws NotBuilt.
std::unique_ptr<TilePass<1>> make_load(const Entry& entry, const RodGroup& group);

} // namespace skein::replay
