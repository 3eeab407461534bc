// Items by key: where those of each key begin, and their values in rising order, the same for any number of threads.
#pragma once

#include "parallel/blocks.hpp"

#include <atomic>

namespace skein {

/// Increments a counter and returns its value before. `single_thread`: no other thread counts.
inline std::uint32_t count_one(std::uint32_t& counter, bool single_thread) {
    return single_thread
               ? counter++
               : std::atomic_ref(counter).fetch_add(1, std::memory_order_relaxed); // a locked addition costs 8 ns
}

/// visit(body) calls body(key, value) for every item, by threads in any order; it is called twice. Keys: 0 .. keys - 1.
template <class Visit> void group(const Threads& threads, std::size_t keys, Visit&& visit,
                                  std::vector<std::uint32_t>& begin, std::vector<std::uint32_t>& values) {
    const bool single_thread = threads.count() == 1;
    begin.assign(keys + 1, 0);
    visit([&](std::size_t key, std::uint32_t) { count_one(begin[key], single_thread); });
    values.resize(begins_from_counts(threads, begin));
    std::vector<std::uint32_t> next(begin);
    visit([&](std::size_t key, std::uint32_t value) { values[count_one(next[key], single_thread)] = value; });
    for_blocks(threads, keys, [&](std::size_t first, std::size_t last, std::size_t) {
        for (std::size_t key = first; key < last; ++key) {
            std::uint32_t *low = values.data() + begin[key], *high = values.data() + begin[key + 1];
            if (high - low > 16) {
                std::sort(low, high);
                continue;
            }
            for (std::uint32_t* at = low + 1; at < high; ++at) { // a few: by insertion
                const std::uint32_t value = *at;
                std::uint32_t* to = at;
                for (; to > low && to[-1] > value; --to) *to = to[-1];
                *to = value;
            }
        }
    });
}

} // namespace skein
