// Figures of the steps of a bed, by tile and lane: what its method takes and adds.                        theory.md
// (125)
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/index.hpp"
#include "skein/tiles/tile.hpp"
#include "tiles/rods.hpp"

#include <algorithm>
#include <vector>

namespace skein {

/// Figures of the rods of one program, whatever the width of its tiles.
class BedFigures {
public:
    virtual ~BedFigures() = default;
    /// Speed of the fastest node, or a bound of that of a body's surface, after the last step, m/s.
    virtual double fastest() const = 0;
    /// Energy that steps have taken from a rod's motion and strain since the start, J.
    virtual double loss(RodPlace rod) const = 0;
    /// Mass that its contacts added in the last step, kg: the mean over directions.
    virtual double added_mass(RodPlace rod) const = 0;
};

template <int W> class BedTiles final : public BedFigures {
public:
    using P = Pack<W>;
    struct Tile {
        P loss{}, added{};
        double fastest = 0;
    };
    void add_tile(std::size_t number) { tiles_.resize(std::max(tiles_.size(), number + 1)); }
    Tile& operator[](std::size_t tile) { return tiles_[tile]; }

    double fastest() const override {
        double most = 0;
        for (const Tile& tile : tiles_) most = std::max(most, tile.fastest);
        return most;
    }
    double loss(RodPlace rod) const override { return tiles_[rod.tile].loss[rod.lane]; }
    double added_mass(RodPlace rod) const override { return tiles_[rod.tile].added[rod.lane]; }

private:
    AlignedVector<Tile> tiles_;
};

} // namespace skein
