// Tiles in numbers that fill a level of the memory, for passes to run over, and the levels themselves.
#pragma once

#include "mechanics/elastic.hpp"
#include "skein/core/aligned.hpp"
#include "support/scenes_for_tests.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <vector>

namespace skein::bench {

struct Level {
    const char* name;
    double state_bytes;
};
inline constexpr Level levels[] = {{"L1", 18e3}, {"L2", 384e3}, {"L3", 8e6}, {"DRAM", 256e6}};

/// Rods of one group, one start state in all lanes, in a state that is somewhat bent and moving; and the loads of one
/// thread.
template <int W> class WorkingSet {
public:
    WorkingSet(const RodGroup& group, double bytes) : slots_(static_cast<std::size_t>(group.slots())), load_(slots_) {
        const auto state = test::shaken_state(group, 1e-4, 1e-2, 1e-3);
        const auto tiles =
            std::max<std::size_t>(1, static_cast<std::size_t>(bytes / static_cast<double>(slots_ * sizeof(Slot<W>))));
        first_.resize(slots_);
        for (std::size_t k = 0; k < slots_; ++k)
            for (int i = 0; i < W; ++i) {
                set_lane(first_[k].position, i, lane(state[k].position, 0));
                set_lane(first_[k].velocity, i, lane(state[k].velocity, 0));
                set_lane(first_[k].director, i, lane(state[k].director, 0));
                set_lane(first_[k].spin, i, lane(state[k].spin, 0));
            }
        slot_.resize(tiles * slots_);
        for (std::size_t t = 0; t < tiles; ++t) {
            RodTile<W> tile{slot_.data() + t * slots_,
                            group.element.data(),
                            group.voronoi.data(),
                            &group,
                            group.elements(),
                            t,
                            {},
                            W};
            for (int i = 0; i < W; ++i) tile.index[i] = static_cast<std::int64_t>(t) * W + i;
            tiles_.push_back(tile);
        }
        reset();
        const ElasticPass<IncompressibleLaw, W> elastic({});
        elastic.run(tiles_[0], load_.data(), {}); // loads for passes that only read them
    }
    void reset() {
        for (const RodTile<W>& tile : tiles_)
            std::memcpy(static_cast<void*>(tile.slot), first_.data(), slots_ * sizeof(Slot<W>));
    }
    const std::vector<RodTile<W>>& tiles() const { return tiles_; }
    SlotLoad<W>* load() { return load_.data(); }
    double elements() const { return static_cast<double>(tiles_.size() * W) * tiles_[0].n; }
    double state_bytes() const { return static_cast<double>(slot_.size() * sizeof(Slot<W>)); }

private:
    std::size_t slots_;
    AlignedVector<Slot<W>> first_, slot_;
    AlignedVector<SlotLoad<W>> load_;
    std::vector<RodTile<W>> tiles_;
};

/// Whether a tile of n elements and its loads lie in L1 together.
template <int W> bool fits_in_l1(long n) {
    const long size = sysconf(_SC_LEVEL1_DCACHE_SIZE);
    return (n + 1) * static_cast<long>(sizeof(Slot<W>) + sizeof(SlotLoad<W>)) <= (size > 0 ? size : 32768);
}

} // namespace skein::bench
