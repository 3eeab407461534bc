// Passes of a rigid body in place of those of a rod. A body is one element and one node, its centre of mass, in one
// slot. Drift, kick and loads are those of rods, with the inertia of the whole body. theory.md (59)
#pragma once

#include "skein/tiles/tile.hpp"

namespace skein {

/// Pass in place of the elastic one: nothing is strained, and there are no loads yet.
template <int W> class UnstrainedPass final : public TilePass<W> {
public:
    bool adds_loads() const override { return false; }
    void run(const RodTile<W>&, SlotLoad<W>* load, const Step&) const override { load[0] = {{}, {}, Pack<W>(1.0)}; }
};

} // namespace skein
