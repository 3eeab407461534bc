// Loops over arrays in blocks, and prefix sums by them. The blocks are the same for any number of threads.
#pragma once

#include "parallel/threads.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace skein {

inline constexpr std::size_t block_size = 1024;
inline std::size_t blocks_of(std::size_t n) { return (n + block_size - 1) / block_size; }

/// body(begin, end, block) over [0, n).
template <class F> void for_blocks(const Threads& threads, std::size_t n, F&& body) {
    threads.for_each(blocks_of(n), [&](std::size_t block, int) {
        body(block * block_size, std::min(n, (block + 1) * block_size), block);
    });
}

/// Turns counts into where each begins, and returns their sum.
inline std::uint32_t begins_from_counts(const Threads& threads, std::vector<std::uint32_t>& counts) {
    std::vector<std::uint32_t> sums(blocks_of(counts.size()));
    for_blocks(threads, counts.size(), [&](std::size_t begin, std::size_t end, std::size_t block) {
        sums[block] = std::accumulate(counts.begin() + static_cast<std::ptrdiff_t>(begin),
                                      counts.begin() + static_cast<std::ptrdiff_t>(end), 0u);
    });
    std::uint32_t sum = 0;
    for (std::uint32_t& s : sums) s = std::exchange(sum, sum + s);
    for_blocks(threads, counts.size(), [&](std::size_t begin, std::size_t end, std::size_t block) {
        std::uint32_t at = sums[block];
        for (std::size_t i = begin; i < end; ++i) counts[i] = std::exchange(at, at + counts[i]);
    });
    return sum;
}

} // namespace skein
