// Held ends that slide in some lab directions. theory.md (47a)
//   v <- s v + (1 - s) u'     after the kick; s: 1 in the free directions, u': the velocity of a moved end, or 0
// The node has the mass of its half element. A clamp has its half cell, which depends on the wall's frame alone, so
// that it may stand anywhere.
#pragma once

#include "mechanics/moving_ends.hpp"
#include "skein/core/aligned.hpp"
#include "skein/tiles/mapping.hpp"

#include <memory>
#include <vector>

namespace skein {

template <int W, class Map = Across<W>> class SlidePass final : public TilePass<W> {
public:
    /// `walls`: of rods across.
    explicit SlidePass(std::shared_ptr<EndWalls<W>> walls = nullptr) : walls_(std::move(walls)) {}

    void expect(std::size_t tiles) override { tiles_.resize(tiles); }

    void bind(const RodTile<W>& rod) override {
        if constexpr (!Map::along) walls_->bind(rod);
        AlignedVector<Node>& nodes = tiles_[rod.number];
        const auto ends = [&](const RodGroup& group, auto&& add) {
            for (const int i : {0, group.elements()})
                if (group.slides(i)) add(i, group.free_directions(i));
        };
        if constexpr (Map::along) {
            for (const LaneRange& range : rod.strands->ranges())
                ends(*range.group, [&](int slot, const Vec3d& free) {
                    const auto [row, l] = rod.strands->place(range.lane, slot);
                    Node node{row, false, broadcast<W>(Vec3d{1, 1, 1})}; // lanes of others stay as they are
                    set_lane(node.free, l, free);
                    nodes.push_back(node);
                });
        } else {
            ends(*rod.group, [&](int slot, const Vec3d& free) {
                nodes.push_back({slot, slot > 0, broadcast<W>(free)});
            });
        }
    }

    void run(const RodTile<W>& rod, SlotLoad<W>*, const Step& step) const override {
        for (const Node& node : tiles_[rod.number]) {
            Vec3<P>& v = rod.slot[node.row].velocity;
            v = scale(node.free, v);
            if (!walls_ || !walls_->moving()) continue;
            const Vec3<P> held = broadcast<W>(Vec3d{1, 1, 1}) - node.free;
            v += scale(held, walls_->velocity(node.last ? EndWalls<W>::end : EndWalls<W>::start, rod, step));
        }
    }

private:
    using P = Pack<W>;
    struct Node {
        int row;
        bool last;    ///< rods across: true at their end
        Vec3<P> free; ///< 1 in the free directions, 0 in others
    };
    std::shared_ptr<EndWalls<W>> walls_;
    std::vector<AlignedVector<Node>> tiles_; ///< by tile number
};

} // namespace skein
