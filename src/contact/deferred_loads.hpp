// Bodies in blocks, each the work of one task, and loads that contacts of one block exert on elements of blocks behind it. A task
// adds to the bodies of its own block as it goes; the rest is deferred until both blocks are done, and is added in order of the
// blocks it comes from. Blocks are those of the scene (SceneSlots), so these sums have the same bits for any threads, ranks and
// lists.
//
//   block A:  pairs (a1, b) (a1, c) (a2, d) ...     that touch, packed; forces eight at a time
//                     |       |       |
//                  b in A   c in B   d in C
//                     |       |       |
//   loads of A <------+       |       |             as A goes, in order of pairs
//   deferred A -> B  <--------+       |             added to B when B has gone through its own pairs
//   deferred A -> C  <----------------+             added to C then, before those B -> C
#pragma once

#include "contact/pair_list.hpp"

#include <span>
#include <type_traits>

namespace skein {

/// Load of a contact on an element.
struct alignas(32) ElementLoad {
    Vec3d first; ///< force at its first node, lab, N
    double unused;
    Vec3d second; ///< at its second
    double unused_too;
    Vec3d couple; ///< lab, N m
    double nothing;

    ElementLoad& operator+=(const ElementLoad& o) {
        first += o.first, second += o.second, couple += o.couple;
        return *this;
    }
};
static_assert(sizeof(ElementLoad) == 96 && std::is_trivially_default_constructible_v<ElementLoad>);

/// Consecutive windows and their slots; the last ones are behind.
struct ContactBlock {
    std::uint32_t first_window, last_window, first_slot, last_slot;
    bool needs_ghosts; ///< some of its pairs have an element of a ghost
};

class DeferredLoads {
public:
    /// Loads of one block on one behind it.
    struct Route {
        std::uint32_t from, to;
        std::size_t begin, end; ///< of its loads; the latter as they are now
    };

    std::span<const ContactBlock> blocks() const { return blocks_; }

    /// Blocks of these bodies, and room for a load per pair of different ones.
    void make_room(const PairList& list, const Exposure& bodies, const Threads& threads);

    /// Before the contacts of a block: where its next loads go, by block. `next` belongs to the thread.
    void open(std::size_t block, std::vector<std::size_t>& next) const;
    /// Place for loads on bodies of other blocks.
    struct Deferring {
        ElementLoad* load;
        std::uint32_t* slot;
        const std::uint32_t* block_of_window;
        std::size_t* next;

        SKEIN_INLINE void defer(std::int32_t window, std::uint32_t on, const ElementLoad& exerted) {
            const std::size_t at = next[block_of_window[window]]++;
            load[at] = exerted;
            slot[at] = on;
        }
    };
    Deferring deferring(std::vector<std::size_t>& next) {
        return {load_.data(), slot_.data(), block_of_window_.data(), next.data()};
    }
    void close(std::size_t block, const std::vector<std::size_t>& next);
    /// The first block that may defer loads to this one; itself if none does.
    std::size_t first_sender(std::size_t block) const;
    /// add(slot, load) for all loads deferred to a block, in order.
    template <class Add> void add_deferred(std::size_t block, Add&& add) const {
        for (std::size_t r = received_[block]; r < received_[block + 1]; ++r) {
            const Route& route = route_[to_[r]];
            for (std::size_t i = route.begin; i < route.end; ++i) add(slot_[i], load_[i]);
        }
    }

private:
    void cut(const Exposure& bodies);

    std::vector<ContactBlock> blocks_;
    std::vector<std::uint32_t> block_of_window_;
    std::vector<Route> route_;                 ///< by sender, then receiver
    std::vector<std::size_t> sent_, received_; ///< by block: where its routes begin in route_ and in to_
    std::vector<std::uint32_t> to_;            ///< routes by receiver, then sender
    AlignedVector<ElementLoad> load_;
    std::vector<std::uint32_t> slot_; ///< of each load
};

} // namespace skein
