// Items by key: where those of each key begin, and their values in rising order, the same for any number of threads.
#pragma once

#include "parallel/blocks.hpp"

#include <bit>

namespace skein {

/// Groups of items, which come in parts: visit(part, body) calls body(key, value) for each of a part; it is called
/// twice. Where several threads work, items are first dealt into bins of consecutive keys, a bin for one thread each,
/// so that no two threads count the same.
class Grouping {
public:
    template <class Visit, class Values> void group(const Threads& threads, std::size_t keys, std::size_t parts,
                                                    Visit&& visit, std::vector<std::uint32_t>& begin, Values& values) {
        begin.assign(keys + 1, 0);
        if (threads.count() == 1) {
            const auto all = [&](auto&& body) {
                for (std::size_t part = 0; part < parts; ++part) visit(part, body);
            };
            std::size_t count = 0;
            all([&](std::size_t, std::uint32_t) { ++count; });
            values.resize(count);
            place({0, keys}, 0, all, begin, values.data());
        } else {
            deal(threads, keys, parts, visit);
            values.resize(item_.size());
            threads.for_each(bins, [&](std::size_t bin, int) {
                place(
                    {bin << shift_, std::min(keys, (bin + 1) << shift_)}, bin_begin_[bin],
                    [&](auto&& body) {
                        for (std::size_t i = bin_begin_[bin]; i < bin_begin_[bin + 1]; ++i)
                            body(item_[i].key, item_[i].value);
                    },
                    begin, values.data());
            });
        }
        begin[keys] = static_cast<std::uint32_t>(values.size());
    }

private:
    static constexpr std::size_t bins = 64, parts_of_thread = 4;
    struct Item {
        std::uint32_t key, value;
    };
    struct Keys {
        std::size_t first, last;
    };

    /// Items in order of bins, then of shares of the parts.
    template <class Visit> void deal(const Threads& threads, std::size_t keys, std::size_t parts, Visit&& visit) {
        shift_ = std::bit_width(keys / bins);
        const std::size_t shares = std::min(parts, parts_of_thread * static_cast<std::size_t>(threads.count()));
        next_.assign(shares * bins, 0);
        const auto of_shares = [&](auto&& body) {
            threads.for_each(shares, [&](std::size_t share, int) {
                for (std::size_t part = share * parts / shares; part < (share + 1) * parts / shares; ++part)
                    visit(part, [&](std::size_t key, std::uint32_t value) {
                        body(next_[share * bins + (key >> shift_)], key, value);
                    });
            });
        };
        of_shares([](std::size_t& count, std::size_t, std::uint32_t) { ++count; });
        std::size_t at = 0;
        for (std::size_t bin = 0; bin < bins; ++bin) {
            bin_begin_[bin] = at;
            for (std::size_t share = 0; share < shares; ++share) {
                std::size_t& next = next_[share * bins + bin];
                next = std::exchange(at, at + next);
            }
        }
        bin_begin_[bins] = at;
        item_.resize(at);
        of_shares([&](std::size_t& next, std::size_t key, std::uint32_t value) {
            item_[next++] = {static_cast<std::uint32_t>(key), value};
        });
    }

    /// The values of some keys, from `first` on.
    template <class Visit> static void place(Keys keys, std::size_t first, Visit&& visit,
                                             std::vector<std::uint32_t>& begin, std::uint32_t* values) {
        visit([&](std::size_t key, std::uint32_t) { ++begin[key]; });
        auto at = static_cast<std::uint32_t>(first);
        for (std::size_t key = keys.first; key < keys.last; ++key) begin[key] = at += begin[key];
        visit([&](std::size_t key, std::uint32_t value) { values[--begin[key]] = value; });
        for (std::size_t key = keys.first; key < keys.last; ++key)
            sort(values + begin[key], values + (key + 1 < keys.last ? begin[key + 1] : at));
    }

    static void sort(std::uint32_t* low, std::uint32_t* high) {
        if (high - low > 16) {
            std::sort(low, high);
            return;
        }
        for (std::uint32_t* at = low + 1; at < high; ++at) { // a few: by insertion
            const std::uint32_t value = *at;
            std::uint32_t* to = at;
            for (; to > low && to[-1] > value; --to) *to = to[-1];
            *to = value;
        }
    }

    int shift_ = 0; ///< a bin has 2^shift keys
    std::size_t bin_begin_[bins + 1];
    std::vector<std::size_t> next_; ///< by share and bin
    std::vector<Item> item_;
};

} // namespace skein
