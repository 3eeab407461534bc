// Pass that holds nodes and elements inside a rod, after the kick. theory.md (47)
#pragma once

#include "rod/held.hpp"
#include "skein/tiles/tile.hpp"

namespace skein {

template <int W> class HoldPass final : public TilePass<W> {
public:
    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step&) const override { apply_hold<W>(*rod.group, rod.slot); }
};

} // namespace skein
