// How published rings close: node n is a copy of node 0. Positions of copies are set with the constraints on values,
// velocities with those on rates, before dampers act: until the next kick the closing element sees node 0 undamped. W
// = 1.
#pragma once

#include "skein/tiles/tile.hpp"

namespace skein::replay {

class ClosePositionPass final : public TilePass<1> {
public:
    void run(const RodTile<1>& rod, SlotLoad<1>*, const Step&) const override {
        rod.slot[rod.n].position = rod.slot[0].position;
    }
};

class CloseVelocityPass final : public TilePass<1> {
public:
    void run(const RodTile<1>& rod, SlotLoad<1>*, const Step&) const override {
        rod.slot[rod.n].velocity = rod.slot[0].velocity;
    }
};

} // namespace skein::replay
