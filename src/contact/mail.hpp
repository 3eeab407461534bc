// Rods in blocks, each the work of one task, and what contacts of one block do to elements of those behind it. A task adds to the
// rods of its own block as it goes; the rest waits in the mail until both blocks are done, and is added in order of the blocks it
// comes from. Blocks are the same whatever touches, so these sums have the same bits for any threads, ranks and lists.
#pragma once

#include "contact/capsules.hpp"
#include "contact/pair_list.hpp"

#include <span>
#include <type_traits>

namespace skein {

/// What a contact does to an element.
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

/// Consecutive rods and their slots.
struct RodBlock {
    std::uint32_t first_rod, last_rod, first_slot, last_slot; ///< the last ones are behind
};

class Mail {
public:
    /// From one block to one behind it.
    struct Route {
        std::uint32_t from, to;
        std::size_t begin, end; ///< of its letters; the latter as they are now
    };

    Mail() = default;
    explicit Mail(const Capsules& capsules);

    std::span<const RodBlock> blocks() const { return blocks_; }
    std::uint32_t block_of(const Capsules& capsules, std::uint32_t slot) const {
        return block_of_rod_[static_cast<std::size_t>(capsules.rod[slot])];
    }

    /// Room for a letter per pair of different blocks.
    void make_room(const PairList& list, const Capsules& capsules, const Threads& threads);

    /// Before the contacts of a block: where its next letters go, by block. `next` belongs to the thread.
    void open(std::size_t block, std::vector<std::size_t>& next) const;
    /// Where a task posts what it has for rods of other blocks.
    struct Desk {
        ElementLoad* letter;
        std::uint32_t* address;
        const std::uint32_t* block_of_rod;
        std::size_t* next;

        SKEIN_INLINE void post(std::int32_t rod, std::uint32_t slot, const ElementLoad& load) {
            const std::size_t at = next[block_of_rod[rod]]++;
            letter[at] = load;
            address[at] = slot;
        }
    };
    Desk desk(std::vector<std::size_t>& next) { return {letter_.data(), address_.data(), block_of_rod_.data(), next.data()}; }
    void close(std::size_t block, const std::vector<std::size_t>& next);
    /// The first block that may write to this one; itself if none does.
    std::size_t first_sender(std::size_t block) const;
    /// take(slot, load) for all that came, in order.
    template <class Take> void deliver(std::size_t block, Take&& take) const {
        for (std::size_t r = received_[block]; r < received_[block + 1]; ++r) {
            const Route& route = route_[to_[r]];
            for (std::size_t i = route.begin; i < route.end; ++i) take(address_[i], letter_[i]);
        }
    }

private:
    std::vector<RodBlock> blocks_;
    std::vector<std::uint32_t> block_of_rod_;
    std::vector<Route> route_;                 ///< by sender, then receiver
    std::vector<std::size_t> sent_, received_; ///< by block: where its routes begin in route_ and in to_
    std::vector<std::uint32_t> to_;            ///< routes by receiver, then sender
    AlignedVector<ElementLoad> letter_;
    std::vector<std::uint32_t> address_; ///< slots
};

} // namespace skein
