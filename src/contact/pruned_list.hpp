// Candidates that may touch before long: those of each block within a margin when all were last checked. Each block has
// its own part of every array, with room for the padding of earlier blocks. GROMACS prunes its lists of pairs likewise
// (docs/references.md).
#pragma once

#include "contact/pair_list.hpp"

#include <algorithm>

namespace skein {

class PrunedList {
public:
    /// Candidates of a block, a column each, from `begin` on; `count` of them, and copies of the last behind these.
    struct Part {
        std::uint32_t* candidate; ///< its number in the list
        Pair* pair;
        std::uint8_t* vertices;
        std::uint32_t& count;
    };

    /// Room for any candidates of each block; none is in it.
    void make_room(const PairList& list, std::size_t blocks) {
        const std::size_t room = list.count() + (blocks + 1) * PairList::padding;
        candidate_.need(room);
        pair_.need(room);
        vertices_.need(room);
        count_.assign(blocks, 0);
    }
    /// Part of a block, whose first candidate has the number `first` in the list.
    Part of(std::size_t block, std::uint32_t first) {
        const std::size_t begin = first + block * PairList::padding;
        return {candidate_.data() + begin, pair_.data() + begin, vertices_.data() + begin, count_[block]};
    }
    static void pad(const Part& part) {
        if (part.count == 0) return;
        const std::uint32_t last = part.count - 1;
        std::fill_n(part.candidate + part.count, PairList::padding, part.candidate[last]);
        std::fill_n(part.pair + part.count, PairList::padding, part.pair[last]);
        std::fill_n(part.vertices + part.count, PairList::padding, part.vertices[last]);
    }

private:
    UnsetArray<std::uint32_t> candidate_;
    UnsetArray<Pair> pair_;
    UnsetArray<std::uint8_t> vertices_;
    std::vector<std::uint32_t> count_; ///< by block
};

} // namespace skein
