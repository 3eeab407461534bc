#include "contact/deferred_loads.hpp"

#include <algorithm>
#include <utility>

namespace skein {

void DeferredLoads::cut(const Exposure& bodies) {
    blocks_.clear();
    block_of_window_.clear();
    std::int64_t last = -1;
    for (std::uint32_t w = 0; w < bodies.window.size(); ++w) {
        const std::int64_t block = bodies.scene().block_of(bodies.window[w].gid);
        if (block != last) blocks_.push_back({w, w, bodies.window[w].first_slot, 0, false});
        last = block;
        blocks_.back().last_window = w + 1;
        blocks_.back().last_slot = bodies.end_of(w);
        block_of_window_.push_back(static_cast<std::uint32_t>(blocks_.size()) - 1);
    }
}

void DeferredLoads::make_room(const PairList& list, const Exposure& bodies, const Threads& threads) {
    cut(bodies);
    struct Wanted {
        std::uint32_t to;
        std::size_t loads;
    };
    std::vector<std::vector<Wanted>> wanted(blocks_.size());
    std::vector<std::vector<std::size_t>> loads_to(static_cast<std::size_t>(threads.count()),
                                                   std::vector<std::size_t>(blocks_.size(), 0));
    threads.for_each(blocks_.size(), [&](std::size_t from, int thread) {
        std::vector<std::size_t>& loads = loads_to[static_cast<std::size_t>(thread)];
        ContactBlock& block = blocks_[from];
        for (std::uint32_t i = list.first[block.first_slot]; i < list.first[block.last_slot]; ++i) {
            const auto [a, b] = list.pair[i];
            block.needs_ghosts |= !bodies.owns_slot(a) || !bodies.owns_slot(b);
            if (b < block.last_slot || !bodies.owns_slot(b)) continue;
            const std::uint32_t to = block_of_window_[static_cast<std::size_t>(bodies.window_of[b])];
            if (loads[to]++ == 0) wanted[from].push_back({to, 0});
        }
        std::sort(wanted[from].begin(), wanted[from].end(), [](const Wanted& x, const Wanted& y) { return x.to < y.to; });
        for (Wanted& w : wanted[from]) w.loads = std::exchange(loads[w.to], 0);
    });
    route_.clear();
    sent_.clear();
    std::size_t loads = 0;
    for (std::uint32_t from = 0; from < blocks_.size(); ++from) {
        sent_.push_back(route_.size());
        for (const Wanted& w : wanted[from]) {
            route_.push_back({from, w.to, loads, loads});
            loads += w.loads;
        }
    }
    sent_.push_back(route_.size());
    received_.assign(blocks_.size() + 1, 0);
    for (const Route& route : route_) ++received_[route.to + 1];
    for (std::size_t b = 0; b < blocks_.size(); ++b) received_[b + 1] += received_[b];
    to_.resize(route_.size());
    std::vector<std::size_t> next(received_);
    for (std::uint32_t r = 0; r < route_.size(); ++r) to_[next[route_[r].to]++] = r;
    load_.resize(loads);
    slot_.resize(loads);
}

void DeferredLoads::open(std::size_t block, std::vector<std::size_t>& next) const {
    next.resize(blocks_.size());
    for (std::size_t r = sent_[block]; r < sent_[block + 1]; ++r) next[route_[r].to] = route_[r].begin;
}

void DeferredLoads::close(std::size_t block, const std::vector<std::size_t>& next) {
    for (std::size_t r = sent_[block]; r < sent_[block + 1]; ++r) route_[r].end = next[route_[r].to];
}

std::size_t DeferredLoads::first_sender(std::size_t block) const {
    return received_[block] < received_[block + 1] ? route_[to_[received_[block]]].from : block;
}

} // namespace skein
