// A tile: W rods of one group side by side, one per SIMD lane, or strands of any rods (tiles/strands.hpp), small enough
// for L2. Passes act on it.
#pragma once

#include "skein/rod/rod_group.hpp"
#include "skein/rod/slot.hpp"
#include "skein/tiles/strands.hpp"
#include "skein/time/clock.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace skein {

/// Loads that passes add up within a step, in per-thread scratch, internal and external. They are the force at node k
/// (lab, N) and the couple at element k (body, N m). The element's dilatation of the law serves damping that follows
/// it.
template <int W> struct SlotLoad {
    Vec3<Pack<W>> force, couple;
    Pack<W> dilatation;
};

template <int W> struct JoinedLoad;

template <int W> struct RodTile {
    Slot<W>* slot;                   ///< [last + 1]
    const ElementConstants* element; ///< [n]; null in a tile along, as the next
    const VoronoiConstants* voronoi; ///< [n - 1]
    const RodGroup* group;
    int n;                                 ///< elements; in a tile along the rows of its strands
    std::size_t number;                    ///< number of the tile within its program on this rank
    std::int64_t index[lanes_of<W>];       ///< number in the group of each lane's rod; spare lanes repeat the last rod
    int lanes;                             ///< lanes that carry a rod of their own
    int last = n;                          ///< last node; 0 for bodies, whose element has no second one
    const Strands<W>* strands = nullptr;   ///< strands of a tile along
    std::size_t program = 0;               ///< number of the program of passes
    std::size_t first = 0;                 ///< first rod of a tile across among those of the group on this rank
    const JoinedLoad<W>* joined = nullptr; ///< [last + 1], loads of joints; null where rods are not joined

    const RodGroup& group_of(int l) const { return strands ? strands->group(l) : *group; }
    std::int64_t index_of(int l) const { return strands ? strands->index(l) : index[l]; }
    /// Element of its rod that a lane has in row k; the first where it has none there.
    int element_of(int l, int k) const {
        if (!strands) return k;
        const int at = strands->slot(l, k);
        return at < 0 || at >= group_of(l).elements() ? 0 : at;
    }
};

/// Tile of one rod.
inline RodTile<1> tile_of(const RodGroup& group, std::span<Slot<1>> state, std::int64_t index = 0) {
    return {state.data(),     group.element.data(), group.voronoi.data(), &group, group.elements(), 0, {index}, 1,
            group.slots() - 1};
}

/// One stage of the step, run over a tile while it is in cache. The plan lists the passes and names them, per group or
/// family of groups.
template <int W> class TilePass {
public:
    virtual ~TilePass() = default;
    /// Sets the number of tiles of the program that will be bound.
    virtual void expect(std::size_t) {}
    /// Called once for every tile of the program when tiles are laid out. Tiles across come in order of number, tiles
    /// along from any thread, in any order.
    virtual void bind(const RodTile<W>&) {}
    /// Evaluates again what a bound tile keeps of formulas of places, whose tables have changed.
    virtual void renew(const RodTile<W>&) {}
    /// Called once before each batch of steps, in serial. Results for a step are stored by the step's slot.
    virtual void prepare(std::span<const Step>) {}
    virtual void run(const RodTile<W>& rod, SlotLoad<W>* load, const Step& step) const = 0;
    /// False where the pass moves loads from slot to slot and adds none.
    virtual bool adds_loads() const { return true; }
    /// Appends the memory of the pass from step to step, for a lane of a tile, for checkpoints: as many numbers for all
    /// rods of a group.
    virtual void append_memory(const RodTile<W>&, int, std::vector<double>&) const {}
    /// Restores this memory from the front of `numbers`; returns the number of entries.
    virtual std::size_t restore(const RodTile<W>&, int, std::span<const double>) { return 0; }
};

template <int W> using TilePasses = std::vector<std::unique_ptr<TilePass<W>>>;

} // namespace skein
