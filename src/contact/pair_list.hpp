// Candidate pairs in order, as steps use them until the list is rebuilt, and the pairs beyond the vertices of each.
#pragma once

#include "contact/broad_phase.hpp"

#include <array>

namespace skein {

struct PairList {
    static constexpr std::size_t padding = 72; ///< copies of the last pair, for readers in tiles and ahead

    std::vector<std::uint32_t> first;   ///< first pair of each slot, and the number of pairs
    AlignedVector<Pair> pair;           ///< rising; padded
    std::vector<std::uint8_t> vertices; ///< by pair, see vertices_of_pair; padded
    std::vector<double> paces;          ///< by pair: sum of both elements' (Exposure::pace_of); padded

    PairList() = default;
    PairList(Candidates&& candidates, const Exposure& bodies, const Threads& threads, bool with_neighbours);

    std::size_t count() const { return first.empty() ? 0 : first.back(); }
    /// Number of a pair, a < b, or count() if it is no candidate.
    std::uint32_t find(Pair wanted) const;
    /// The pair of elements a + da and b + db, each -1, 0 or 1 and not both 0, if it is a candidate. No branch depends
    /// on where things are.
    struct Neighbour {
        std::uint32_t pair;
        bool is_candidate;
    };
    Neighbour along_second(std::uint32_t i, int db) const { // a + 0
        const std::uint32_t j = i + static_cast<std::uint32_t>(db);
        const bool is_candidate = (j < count()) & (db != 0);
        const std::uint32_t at = is_candidate ? j : i;
        return {at, is_candidate && pair[at] == Pair{pair[i].a, pair[i].b + static_cast<std::uint32_t>(db)}};
    }
    Neighbour along_first(std::uint32_t i, int da, int db) const { // da not 0, or none
        const std::uint32_t word = da == 0 ? 0 : beyond_[i][da > 0], bit = 1u << (db + 1), before = word & (bit - 1);
        return {(word >> 3) + (before & 1) + (before >> 1), (word & bit) != 0};
    }

private:
    void find_neighbours(const Threads& threads);

    /// Neighbours of pair (a, b) at a - 1 and at a + 1. Three bits mark the partners among b - 1, b, b + 1; the rest is
    /// the number of the first.
    std::vector<std::array<std::uint32_t, 2>> beyond_;
};

} // namespace skein
