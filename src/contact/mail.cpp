#include "contact/mail.hpp"

#include <algorithm>
#include <utility>

namespace skein {

Mail::Mail(const Capsules& capsules) {
    constexpr std::uint32_t enough = 256; // slots: what contacts read and write of them fits the first cache
    const auto rods = static_cast<std::uint32_t>(capsules.first_slot.size() - 1);
    const auto slot = [&](std::uint32_t rod) { return static_cast<std::uint32_t>(capsules.first_slot[rod]); };
    for (std::uint32_t rod = 0, behind = 0; rod < rods; rod = behind) {
        while (behind < rods && (behind == rod || slot(behind + 1) - slot(rod) <= enough)) ++behind;
        block_of_rod_.insert(block_of_rod_.end(), behind - rod, static_cast<std::uint32_t>(blocks_.size()));
        blocks_.push_back({rod, behind, slot(rod), slot(behind)});
    }
}

void Mail::make_room(const PairList& list, const Capsules& capsules, const Threads& threads) {
    struct Wanted {
        std::uint32_t to;
        std::size_t letters;
    };
    std::vector<std::vector<Wanted>> wanted(blocks_.size());
    std::vector<std::vector<std::size_t>> letters_to(static_cast<std::size_t>(threads.count()),
                                                     std::vector<std::size_t>(blocks_.size(), 0));
    threads.for_each(blocks_.size(), [&](std::size_t from, int thread) {
        std::vector<std::size_t>& letters = letters_to[static_cast<std::size_t>(thread)];
        const RodBlock& block = blocks_[from];
        for (std::uint32_t i = list.first[block.first_slot]; i < list.first[block.last_slot]; ++i) {
            if (list.pair[i].b < block.last_slot) continue;
            const std::uint32_t to = block_of(capsules, list.pair[i].b);
            if (letters[to]++ == 0) wanted[from].push_back({to, 0});
        }
        std::sort(wanted[from].begin(), wanted[from].end(), [](const Wanted& x, const Wanted& y) { return x.to < y.to; });
        for (Wanted& w : wanted[from]) w.letters = std::exchange(letters[w.to], 0);
    });
    route_.clear();
    sent_.clear();
    std::size_t letters = 0;
    for (std::uint32_t from = 0; from < blocks_.size(); ++from) {
        sent_.push_back(route_.size());
        for (const Wanted& w : wanted[from]) {
            route_.push_back({from, w.to, letters, letters});
            letters += w.letters;
        }
    }
    sent_.push_back(route_.size());
    received_.assign(blocks_.size() + 1, 0);
    for (const Route& route : route_) ++received_[route.to + 1];
    for (std::size_t b = 0; b < blocks_.size(); ++b) received_[b + 1] += received_[b];
    to_.resize(route_.size());
    std::vector<std::size_t> next(received_);
    for (std::uint32_t r = 0; r < route_.size(); ++r) to_[next[route_[r].to]++] = r;
    letter_.resize(letters);
    address_.resize(letters);
}

void Mail::open(std::size_t block, std::vector<std::size_t>& next) const {
    next.resize(blocks_.size());
    for (std::size_t r = sent_[block]; r < sent_[block + 1]; ++r) next[route_[r].to] = route_[r].begin;
}

void Mail::close(std::size_t block, const std::vector<std::size_t>& next) {
    for (std::size_t r = sent_[block]; r < sent_[block + 1]; ++r) route_[r].end = next[route_[r].to];
}

std::size_t Mail::first_sender(std::size_t block) const {
    return received_[block] < received_[block + 1] ? route_[to_[received_[block]]].from : block;
}

} // namespace skein
