#include "contact/pair_list.hpp"

#include "contact/vertices.hpp"
#include "parallel/blocks.hpp"
#include "skein/core/index.hpp"

#include <algorithm>

namespace skein {

PairList::PairList(Candidates&& candidates, const Exposure& bodies, const Threads& threads, bool with_neighbours)
    : first(std::move(candidates.first)) {
    pair.resize(count() + padding);
    vertices.assign(count() + padding, 0);
    paces.assign(count() + padding, 0);
    for_blocks(threads, first.size() - 1, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t a = begin; a < end; ++a)
            for (std::size_t i = first[a]; i < first[a + 1]; ++i) {
                pair[i] = {static_cast<std::uint32_t>(a), candidates.partner[i]};
                vertices[i] = vertices_of_pair(bodies, pair[i]);
                paces[i] = bodies.pace_of(pair[i].a) + bodies.pace_of(pair[i].b);
            }
    });
    if (count() > 0) std::fill_n(pair.begin() + static_cast<std::ptrdiff_t>(count()), padding, pair[count() - 1]);
    if (with_neighbours) find_neighbours(threads);
}

std::uint32_t PairList::find(Pair wanted) const {
    const auto begin = pair.begin() + first[wanted.a], end = pair.begin() + first[wanted.a + 1];
    const auto at = std::lower_bound(begin, end, wanted);
    return static_cast<std::uint32_t>(at != end && *at == wanted ? at - pair.begin()
                                                                 : static_cast<std::ptrdiff_t>(count()));
}

void PairList::find_neighbours(const Threads& threads) {
    const std::size_t slots = first.size() - 1;
    beyond_.resize(count());
    for_blocks(threads, slots, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t a = begin; a < end; ++a)
            for (const int side : {0, 1}) {
                const std::size_t other = side ? a + 1 : a - 1; // another rod's slot has no element there, and no pairs
                std::uint32_t at = other < slots ? first[other] : 0, end = other < slots ? first[other + 1] : 0;
                for (std::uint32_t i = first[a]; i < first[a + 1]; ++i) {
                    const std::uint32_t from = pair[i].b - 1;
                    while (at < end && pair[at].b < from) ++at;
                    std::uint32_t word = at << 3;
                    for (std::uint32_t j = at; j < end && pair[j].b <= from + 2; ++j) word |= 1u << (pair[j].b - from);
                    nth(beyond_[i], side) = word;
                }
            }
    });
}

} // namespace skein
