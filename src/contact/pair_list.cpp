#include "contact/pair_list.hpp"

#include "contact/group.hpp"

#include <algorithm>

namespace skein {

PairList::PairList(Candidates&& candidates, const Capsules& capsules, const Threads& threads, bool with_neighbours)
    : first(std::move(candidates.first)) {
    pair.resize(count() + padding);
    for_blocks(threads, first.size() - 1, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t a = begin; a < end; ++a)
            for (std::size_t i = first[a]; i < first[a + 1]; ++i) pair[i] = {static_cast<std::uint32_t>(a), candidates.partner[i]};
    });
    if (count() > 0) std::fill_n(pair.begin() + static_cast<std::ptrdiff_t>(count()), padding, pair[count() - 1]);
    reverse_pairs(threads);
    if (with_neighbours) find_neighbours(threads);
    cut(capsules);
}

void PairList::reverse_pairs(const Threads& threads) {
    const auto visit = [&](auto&& body) {
        for_blocks(threads, count(), [&](std::size_t begin, std::size_t end, std::size_t) {
            for (std::size_t i = begin; i < end; ++i) body(pair[i].b, static_cast<std::uint32_t>(i));
        });
    };
    group(threads, first.size() - 1, visit, reverse_begin, reverse);
}

void PairList::find_neighbours(const Threads& threads) {
    const std::size_t slots = first.size() - 1;
    beyond_.resize(count());
    for_blocks(threads, slots, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t a = begin; a < end; ++a)
            for (const int side : {0, 1}) {
                const std::size_t other = side ? a + 1 : a - 1; // of another rod only if that slot has no element, and no pairs
                std::uint32_t at = other < slots ? first[other] : 0, behind = other < slots ? first[other + 1] : 0;
                for (std::uint32_t i = first[a]; i < first[a + 1]; ++i) {
                    const std::uint32_t from = pair[i].b - 1;
                    while (at < behind && pair[at].b < from) ++at;
                    std::uint32_t word = at << 3;
                    for (std::uint32_t j = at; j < behind && pair[j].b <= from + 2; ++j) word |= 1u << (pair[j].b - from);
                    beyond_[i][static_cast<std::size_t>(side)] = word;
                }
            }
    });
}

void PairList::cut(const Capsules& capsules) {
    constexpr std::uint32_t enough = 512;
    const auto rods = static_cast<std::uint32_t>(capsules.first_slot.size() - 1);
    const auto begin_of = [&](std::uint32_t rod) { return first[static_cast<std::size_t>(capsules.first_slot[rod])]; };
    for (std::uint32_t rod = 0, behind = 0; rod < rods; rod = behind) {
        while (behind < rods && behind - rod < enough && begin_of(behind) - begin_of(rod) < enough) ++behind;
        std::uint32_t needed = begin_of(behind);
        for (auto slot = static_cast<std::size_t>(capsules.first_slot[rod]);
             slot < static_cast<std::size_t>(capsules.first_slot[behind]); ++slot)
            if (reverse_begin[slot] < reverse_begin[slot + 1]) needed = std::min(needed, reverse[reverse_begin[slot]]);
        tasks.push_back({rod, behind, begin_of(rod), begin_of(behind), needed});
    }
}

} // namespace skein
