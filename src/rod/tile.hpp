// A tile: W rods of one group side by side, one per SIMD lane, small enough for L2; and what acts on it.
#pragma once

#include "rod/rod_group.hpp"
#include "rod/slot.hpp"
#include "time/clock.hpp"

#include <cstdint>
#include <span>
#include <string>

namespace skein {

/// What passes hand on within a step, in per-thread scratch: force at node k (lab, N) and couple at element k (body, N m), internal
/// and external; and the element's dilatation as its law has it, which damping may follow.
template <int W> struct SlotLoad {
    Vec3<Pack<W>> force, couple;
    Pack<W> dilatation;
};

template <int W> struct RodTile {
    Slot<W>* slot;                   ///< [n + 1]
    const ElementConstants* element; ///< [n]
    const VoronoiConstants* voronoi; ///< [n - 1]
    const RodGroup* group;
    int n;                           ///< elements
    std::size_t number;              ///< of the tile within its group on this rank
    std::int64_t index[W];           ///< number in the group of each lane's rod; spare lanes repeat the last rod
    int lanes;                       ///< lanes that carry a rod of their own
};

/// One stage of the step, run over a tile while it is in cache. The plan strings passes together, per group.
template <int W> class TilePass {
public:
    virtual ~TilePass() = default;
    virtual std::string_view name() const = 0;
    /// Called once for every tile of the group, in order of number, when tiles are laid out.
    virtual void bind(const RodTile<W>&) {}
    /// Called once before the tiles of a batch of steps are visited; serial.
    virtual void prepare(std::span<const Step>) {}
    virtual void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const = 0;
};

} // namespace skein
