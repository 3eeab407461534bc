// Blocks of bodies, strips of blocks, and loads of contacts of one strip on elements of later strips.
//
//   strip 1:  blocks A B        strip 2:  blocks C D        each pair (a, b), a < b, is the work of a's block
//   task 1:   B: loads of B;  then A: loads of A and B        deferred B -> C, B -> D, A -> C, A -> D
//   task 2:   D: loads of D;  then C: loads of C and D
//   then:     deferred loads of C: those of B, then those of A; of D likewise
//
// A strip is the work of one task. The task goes through the blocks from the last to the first and adds to the bodies
// of all of them. Loads on bodies of other strips are deferred until all strips are done. So a slot sums its loads in
// one order wherever strips begin: its own block's, then those of the block before, and so on, pairs rising in each.
// The scene defines the blocks (SceneSlots), so these sums have the same bits for any threads, ranks and lists.
#pragma once

#include "contact/pair_list.hpp"
#include "contact/rows.hpp"

#include <bit>
#include <span>

namespace skein {

/// Consecutive windows and their slots; the last ones are behind.
struct ContactBlock {
    std::uint32_t first_window, last_window, first_slot, last_slot;
    bool needs_ghosts; ///< some of its pairs have an element of a ghost
    bool paired;       ///< some pair, of any block, has an element of it: nothing is exerted on the others
};

/// Consecutive blocks and their slots, of which all need ghosts or none does; the last ones are behind.
struct ContactStrip {
    std::uint32_t first_block, last_block, first_slot, last_slot;
    bool needs_ghosts;
};

class DeferredLoads {
public:
    std::span<const ContactBlock> blocks() const { return blocks_; }
    std::span<const ContactStrip> strips() const { return strips_; }

    /// Blocks of these bodies, strips for these threads, and room for the loads of pairs of different ones.
    /// `with_tangents`: slopes of contacts too.
    void make_room(const PairList& list, const Exposure& bodies, const Threads& threads, bool with_tangents);

    /// Loads of one strip on their way.
    class Deferring {
    public:
        Deferring(DeferredLoads& all, std::size_t strip, std::vector<std::size_t>& next);
        ~Deferring();
        Deferring(const Deferring&) = delete;

        SKEIN_INLINE void defer(std::int32_t window, std::uint32_t slot, const LoadRow& row) {
            const std::size_t at = next_[block_of_window_[window]]++;
            row_[at] = row;
            slot_[at] = slot;
        }
        SKEIN_INLINE void defer(std::int32_t window, std::uint32_t slot, const PointTangent& tangent) {
            defer(window, slot | is_tangent, std::bit_cast<LoadRow>(tangent));
        }

    private:
        DeferredLoads& all_;
        const std::size_t strip_;
        std::vector<std::size_t>& next_; ///< by block: where its next load goes; belongs to the thread
        LoadRow* const row_;
        std::uint32_t* const slot_;
        const std::uint32_t* const block_of_window_;
    };
    /// add(slot, row) for all loads deferred to a block, in order; add(slot, tangent) for slopes of contacts.
    template <class Add> void add_deferred(std::size_t block, Add&& add) const {
        for (std::size_t r = received_[block]; r < received_[block + 1]; ++r) {
            const Route& route = route_[to_[r]];
            for (std::size_t i = route.begin; i < route.end; ++i)
                if (slot_[i] & is_tangent) add(slot_[i] & ~is_tangent, std::bit_cast<PointTangent>(row_[i]));
                else add(slot_[i], row_[i]);
        }
    }

private:
    static constexpr std::uint32_t is_tangent = 1u << 31; ///< bit of a slot whose row is no load
    /// Loads of a strip on a block behind it.
    struct Route {
        std::uint32_t from, to;
        std::size_t begin, end; ///< range of its loads, which grows
    };
    void cut_blocks(const PairList& list, const Exposure& bodies, const Threads& threads);
    void cut_strips(const PairList& list, const Threads& threads);

    std::vector<ContactBlock> blocks_;
    std::vector<ContactStrip> strips_;
    std::vector<std::uint32_t> block_of_window_;
    std::vector<Route> route_;                 ///< by sender, then receiver
    std::vector<std::size_t> sent_, received_; ///< by strip and by block: where its routes begin in route_ and in to_
    std::vector<std::uint32_t> to_;            ///< routes by receiver, then sender from near to far
    UnsetArray<LoadRow> row_;
    UnsetArray<std::uint32_t> slot_; ///< slot of each row
};

} // namespace skein
