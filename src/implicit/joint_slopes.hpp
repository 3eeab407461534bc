// Slopes of the loads of joints by the motion of the slots that they join, for Newton corrections: differences of the
// loads themselves, so that any joint has them, as other loads do (load_slopes.hpp). Slots are moved in colours, no two
// of which a joint feels together.
#pragma once

#include "core/rotation.hpp"
#include "implicit/shared_nodes.hpp"
#include "mechanics/drift.hpp"
#include "tiles/clusters.hpp"

#include <algorithm>
#include <cstdint>
#include <set>
#include <vector>

namespace skein {

template <int W> class JointSlopes {
public:
    using P = Pack<W>;
    using V = Vec3<P>;

    /// Slots, by number in the cluster; those of one row, the two ends of a ring, move as one.
    JointSlopes(const ClusterJoints<W>& joints, std::vector<JoinedSlot> slots) : slots_(std::move(slots)) {
        std::vector<std::set<std::uint32_t>> partners(slots_.size());
        for (const auto& joint : joints.joined_slots())
            for (const std::uint32_t a : joint)
                for (const std::uint32_t b : joint)
                    if (slots_[b].row != JoinedSlot::none) partners[a].insert(b);
        std::vector<std::vector<std::uint32_t>> of_row;
        for (std::uint32_t s = 0; s < slots_.size(); ++s) {
            if (partners[s].empty() || slots_[s].row == JoinedSlot::none) continue;
            of_row.resize(std::max(of_row.size(), slots_[s].row + 1));
            of_row[slots_[s].row].push_back(s);
        }
        std::vector<std::set<std::uint32_t>> felt; // by colour
        for (const auto& together : of_row) {
            if (together.empty()) continue;
            std::set<std::uint32_t> by;
            for (const std::uint32_t s : together) by.insert(partners[s].begin(), partners[s].end());
            const auto apart = [&](const std::set<std::uint32_t>& of_colour) {
                return std::none_of(by.begin(), by.end(), [&](std::uint32_t s) { return of_colour.contains(s); });
            };
            const auto found = static_cast<std::size_t>(std::find_if(felt.begin(), felt.end(), apart) - felt.begin());
            if (found == felt.size()) {
                felt.emplace_back();
                colours_.emplace_back();
            }
            felt[found].insert(by.begin(), by.end());
            Moved& moved = colours_[found].emplace_back(Moved{together, {}});
            moved.felt_by.assign(by.begin(), by.end());
            pairs_ += moved.felt_by.size();
        }
    }

    const std::vector<JoinedSlot>& slots() const { return slots_; }
    /// Pairs of rows that joints couple, each once at least.
    std::vector<std::pair<std::size_t, std::size_t>> coupled_rows() const {
        std::vector<std::pair<std::size_t, std::size_t>> pairs;
        for (const auto& colour : colours_)
            for (const Moved& moved : colour)
                for (const std::uint32_t s : moved.felt_by)
                    if (slots_[s].row != row_of(moved)) pairs.emplace_back(slots_[s].row, row_of(moved));
        return pairs;
    }

    /// Room of a thread.
    struct Work {
        struct Block {
            RowBlock<W> a;
        };
        struct Column {
            V force, couple;
        };
        AlignedVector<Block> slopes;  ///< of all pairs of slots, colour by colour
        AlignedVector<Column> column; ///< of the blocks of a colour, direction by direction
        AlignedVector<Slot<W>> kept;  ///< slots that are moved
        AlignedVector<JoinedLoad<W>> load;
    };

    /// Computes slopes. `still`: loads at the present state; `time`: s, from displacement to velocity; `apart`: m, a
    /// small displacement.
    void compute(const ClusterJoints<W>& joints, Slot<W>* slot, const EndMoments<W>* moments, const Step& step,
                 const P* memory, const JoinedLoad<W>* still, double time, double apart, Work& work) const {
        work.slopes.resize(pairs_);
        work.load.resize(slots_.size());
        std::size_t first = 0;
        for (const auto& colour : colours_) {
            std::size_t blocks = 0;
            for (const Moved& moved : colour) blocks += moved.felt_by.size();
            work.column.resize(std::max(work.column.size(), row_size * blocks));
            for (int i = 0; i < row_size; ++i) {
                const double small = i < 3 ? apart : turned_by;
                work.kept.clear();
                for (const Moved& moved : colour)
                    for (const std::uint32_t s : moved.slots) {
                        work.kept.push_back(slot[s]);
                        move(slot[s], slots_[s], i, small, time);
                    }
                joints.try_state(slot, moments, step, memory, work.load.data());
                differ(colour, slot, still, 1 / small, work, to_index(i) * blocks);
                std::size_t at = 0;
                for (const Moved& moved : colour)
                    for (const std::uint32_t s : moved.slots) slot[s] = work.kept[at++];
            }
            std::size_t block = 0;
            for (const Moved& moved : colour)
                for (const std::uint32_t s : moved.felt_by) {
                    for (int i = 0; i < row_size; ++i)
                        put(work.column[to_index(i) * blocks + block], slot[s], slots_[s], i,
                            work.slopes[first + block].a);
                    ++block;
                }
            first += blocks;
        }
    }
    /// Calls take(slot that feels, slot that moves, block) for all slopes.
    template <class Take> void for_all(const Work& work, Take&& take) const {
        std::size_t at = 0;
        for (const auto& colour : colours_)
            for (const Moved& moved : colour)
                for (const std::uint32_t s : moved.felt_by)
                    take(slots_[s], slots_[moved.slots.front()], work.slopes[at++].a);
    }

private:
    static constexpr double turned_by = 1e-7; ///< rad
    /// Slots that move as one, and those that feel it.
    struct Moved {
        std::vector<std::uint32_t> slots, felt_by;
    };
    std::size_t row_of(const Moved& moved) const { return slots_[moved.slots.front()].row; }

    /// Differences of loads, in one direction. Couples on slots that move are taken to the frame before.
    void differ(const std::vector<Moved>& colour, const Slot<W>* slot, const JoinedLoad<W>* still, double over,
                Work& work, std::size_t block) const {
        std::size_t first = 0;
        for (const Moved& moved : colour) {
            for (const std::uint32_t s : moved.felt_by) {
                V couple = work.load[s].couple;
                const auto own = std::find(moved.slots.begin(), moved.slots.end(), s);
                if (own != moved.slots.end() && slots_[s].about_lab)
                    couple = work.kept[first + to_index(own - moved.slots.begin())].director *
                             transpose_times(slot[s].director, couple);
                work.column[block++] = {P(over) * (work.load[s].force - still[s].force),
                                        P(over) * (couple - still[s].couple)};
            }
            first += moved.slots.size();
        }
    }

    static void move(Slot<W>& s, const JoinedSlot& of, int i, double small, double time) {
        V by{P(i % 3 == 0 ? small : 0.0), P(i % 3 == 1 ? small : 0.0), P(i % 3 == 2 ? small : 0.0)};
        if (i < 3) {
            s.position += by;
            s.velocity = fma(P(1 / time), by, s.velocity);
        } else if (of.turns) {
            if (of.about_lab) by = s.director * by;
            s.director = rotation(by) * s.director;
            s.spin = fma(P(1 / time), by, s.spin);
        }
    }
    static void put(const typename Work::Column& from, const Slot<W>& slot, const JoinedSlot& of, int column,
                    RowBlock<W>& to) {
        const V c = !of.turns      ? V{P(0.0), P(0.0), P(0.0)}
                    : of.about_lab ? transpose_times(slot.director, from.couple)
                                   : from.couple;
        const P all[row_size] = {from.force.x, from.force.y, from.force.z, c.x, c.y, c.z};
        for (int r = 0; r < row_size; ++r) to[r][column] = all[r];
    }

    std::vector<JoinedSlot> slots_;
    std::vector<std::vector<Moved>> colours_;
    std::size_t pairs_ = 0; ///< of a slot that feels and one that moves
};

} // namespace skein
