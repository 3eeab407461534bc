// Slopes of the loads of passes by a rod's own motion, for Newton corrections: differences of the passes themselves, so
// that any load has them. Slots are moved in colours, no two of which a load feels together. A slot moves as its step
// does: with a displacement d its velocity changes by d/h, with a turn its spin. They steer corrections and leave no
// trace in what these end with. Turns and couples are in the body, or in the lab.
#pragma once

#include "core/rotation.hpp"
#include "implicit/block_rows.hpp"
#include "mechanics/drift.hpp"
#include "skein/tiles/tile.hpp"

#include <algorithm>
#include <span>
#include <vector>

namespace skein {

template <int W> class LoadSlopes {
public:
    using P = Pack<W>;
    using V = Vec3<P>;

    explicit LoadSlopes(bool in_lab = false) : in_lab_(in_lab) {}

    /// Computes the slopes of `passes` about the present state. `inner`: loads before them; `total`: after them;
    /// `load`: room for others, all [slots]. `time`: s, from displacement to velocity; `apart`: m, a small
    /// displacement.
    void compute(const RodTile<W>& rod, std::span<const TilePass<W>* const> passes, const SlotLoad<W>* inner,
                 const SlotLoad<W>* total, SlotLoad<W>* load, const Step& step, const P& time, double apart) {
        const bool ring = rod.group->closed();
        const int nodes = rod.last == rod.n ? rod.group->nodes() : 1, slots = rod.last + 1;
        const int elements = rod.n;
        if (blocks_.size() < 3 * to_index(nodes)) blocks_.resize(3 * to_index(nodes));
        const int over = ring ? nodes % 3 : 0, colours = ring ? 3 + over : std::min(3, nodes);
        const auto colour = [&](int k) { return k >= nodes - over ? 3 + k - (nodes - over) : k % 3; };
        for (int c = 0; c < colours; ++c)
            for (int i = 0; i < row_size; ++i) {
                const double small = i < 3 ? apart : turned_by;
                kept_.clear();
                for (int k = 0; k < nodes; ++k) {
                    if (colour(k) != c || (i >= 3 && k >= elements)) continue;
                    kept_.push_back(rod.slot[k]);
                    move(rod.slot[k], i, small, time);
                }
                if (kept_.empty()) continue;
                close_ring(rod);
                std::copy_n(inner, slots, load);
                for (const TilePass<W>* pass : passes) pass->run(rod, load, step);
                for (int k = 0, at = 0; k < nodes; ++k) {
                    if (colour(k) != c || (i >= 3 && k >= elements)) continue;
                    if (in_lab_) load[k].couple = as_in(kept_[to_index(at)], rod.slot[k], load[k].couple);
                    rod.slot[k] = kept_[to_index(at++)];
                    for (int by = -1; by <= 1; ++by) {
                        int row = k + by;
                        if (ring) row = (row + nodes) % nodes;
                        if (row < 0 || row >= nodes) continue;
                        put(block(row, -by), i, rod.slot[row], load[row], total[row], 1 / small, row < elements);
                    }
                }
                close_ring(rod);
            }
    }

    /// Takes the slopes of row k from its matrix.
    void subtract_from(int k, BlockRow<W>& row) {
        RowBlock<W>* const to[3] = {&row.before, &row.diagonal, &row.after};
        for (int by = 0; by < 3; ++by) {
            const RowBlock<W>& slopes = blocks_[3 * to_index(k) + to_index(by)].a;
            for (int i = 0; i < row_size; ++i)
                for (int j = 0; j < row_size; ++j) (*to[by])[i][j] -= slopes[i][j];
        }
    }

private:
    static constexpr double turned_by = 1e-7; ///< rad
    struct Block {
        RowBlock<W> a;
    };

    RowBlock<W>& block(int row, int by) { return blocks_[to_index(3 * row + 1 + by)].a; }

    void move(Slot<W>& s, int i, double small, const P& time) const {
        V by{P(i % 3 == 0 ? small : 0.0), P(i % 3 == 1 ? small : 0.0), P(i % 3 == 2 ? small : 0.0)};
        if (i < 3) {
            s.position += by;
            s.velocity = fma(P(1.0) / time, by, s.velocity);
        } else {
            if (in_lab_) by = s.director * by;
            s.director = rotation(by) * s.director;
            s.spin = fma(P(1.0) / time, by, s.spin);
        }
    }
    /// Body components of a couple on a slot that was moved in the frame of the slot.
    static V as_in(const Slot<W>& slot, const Slot<W>& moved, const V& couple) {
        return slot.director * transpose_times(moved.director, couple);
    }
    void put(RowBlock<W>& to, int column, const Slot<W>& slot, const SlotLoad<W>& moved, const SlotLoad<W>& still,
             double over, bool has_element) const {
        const V f = P(over) * (moved.force - still.force);
        V c = has_element ? P(over) * (moved.couple - still.couple) : V{};
        if (in_lab_ && has_element) c = transpose_times(slot.director, c);
        const P all[row_size] = {f.x, f.y, f.z, c.x, c.y, c.z};
        for (int r = 0; r < row_size; ++r) to[r][column] = all[r];
    }

    bool in_lab_;
    AlignedVector<Block> blocks_; ///< [3 nodes]: by the slot before, by the own, by the slot after
    AlignedVector<Slot<W>> kept_;
};

} // namespace skein
