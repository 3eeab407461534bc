#include "contact/deferred_loads.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

namespace skein {

namespace {

constexpr std::size_t strips_per_thread = 4, // strips differ in time
    rows_per_pair = 7,                       // rows of near-parallel elements bent near vertices; most pairs have one
    tangents_per_pair = 3;                   // at both ends of their overlap, and where they are nearest

} // namespace

void DeferredLoads::cut_blocks(const PairList& list, const Exposure& bodies, const Threads& threads) {
    blocks_.clear();
    block_of_window_.clear();
    std::int64_t last = -1;
    for (std::uint32_t w = 0; w < bodies.window.size(); ++w) {
        const std::int64_t block = bodies.scene().block_of(bodies.window[w].gid);
        if (block != last) blocks_.push_back({w, w, bodies.window[w].first_slot, 0, false, false});
        last = block;
        blocks_.back().last_window = w + 1;
        blocks_.back().last_slot = bodies.end_of(w);
        block_of_window_.push_back(static_cast<std::uint32_t>(blocks_.size()) - 1);
    }
    threads.for_each(blocks_.size(), [&](std::size_t number, int) {
        ContactBlock& block = blocks_[number];
        const auto pair = [](ContactBlock& one) { std::atomic_ref(one.paired).store(true, std::memory_order_relaxed); };
        const std::uint32_t begin = list.first[block.first_slot], end = list.first[block.last_slot];
        if (begin != end) pair(block);
        for (std::uint32_t i = begin; i < end; ++i) {
            const std::uint32_t b = list.pair[i].b;
            if (b >= block.last_slot) pair(blocks_[nth(block_of_window_, bodies.window_of[b])]);
            if (!bodies.own.empty()) block.needs_ghosts |= !bodies.owns_slot(list.pair[i].a) || !bodies.owns_slot(b);
        }
    });
}

/// Strips have about as many pairs each; where one thread does all, they are as long as they can be.
void DeferredLoads::cut_strips(const PairList& list, const Threads& threads) {
    strips_.clear();
    const std::size_t count = threads.count() == 1 ? 1 : strips_per_thread * to_index(threads.count()),
                      most = (list.count() + count - 1) / count;
    std::size_t pairs = 0;
    for (std::uint32_t b = 0; b < blocks_.size(); ++b) {
        const ContactBlock& block = blocks_[b];
        const std::size_t more = list.first[block.last_slot] - list.first[block.first_slot];
        if (strips_.empty() || strips_.back().needs_ghosts != block.needs_ghosts || pairs + more / 2 > most) {
            strips_.push_back({b, b, block.first_slot, 0, block.needs_ghosts});
            pairs = 0;
        }
        pairs += more;
        strips_.back().last_block = b + 1;
        strips_.back().last_slot = block.last_slot;
    }
}

void DeferredLoads::make_room(const PairList& list, const Exposure& bodies, const Threads& threads,
                              bool with_tangents) {
    const std::size_t rows_of_pair = rows_per_pair + (with_tangents ? tangents_per_pair : 0);
    cut_blocks(list, bodies, threads);
    cut_strips(list, threads);
    struct Wanted {
        std::uint32_t to;
        std::size_t rows;
    };
    std::vector<std::vector<Wanted>> wanted(strips_.size());
    std::vector<std::vector<std::size_t>> rows_to(to_index(threads.count()),
                                                  std::vector<std::size_t>(blocks_.size(), 0));
    threads.for_each(strips_.size(), [&](std::size_t from, int thread) {
        std::vector<std::size_t>& rows = nth(rows_to, thread);
        const ContactStrip& strip = strips_[from];
        for (std::uint32_t i = list.first[strip.first_slot]; i < list.first[strip.last_slot]; ++i) {
            const std::uint32_t b = list.pair[i].b;
            if (b < strip.last_slot || !bodies.owns_slot(b)) continue;
            const std::uint32_t to = nth(block_of_window_, bodies.window_of[b]);
            if (rows[to] == 0) wanted[from].push_back({to, 0});
            rows[to] += rows_of_pair;
        }
        std::sort(wanted[from].begin(), wanted[from].end(),
                  [](const Wanted& x, const Wanted& y) { return x.to < y.to; });
        for (Wanted& w : wanted[from]) w.rows = std::exchange(rows[w.to], 0);
    });
    route_.clear();
    sent_.clear();
    std::size_t rows = 0;
    for (std::uint32_t from = 0; from < strips_.size(); ++from) {
        sent_.push_back(route_.size());
        for (const Wanted& w : wanted[from]) {
            route_.push_back({from, w.to, rows, rows});
            rows += w.rows;
        }
    }
    sent_.push_back(route_.size());
    received_.assign(blocks_.size() + 1, 0);
    for (const Route& route : route_) ++received_[route.to + 1];
    for (std::size_t b = 0; b < blocks_.size(); ++b) received_[b + 1] += received_[b];
    to_.resize(route_.size());
    std::vector<std::size_t> next(received_);
    for (std::uint32_t r = static_cast<std::uint32_t>(route_.size()); r-- > 0;) to_[next[route_[r].to]++] = r;
    row_.need(rows);
    slot_.need(rows);
}

DeferredLoads::Deferring::Deferring(DeferredLoads& all, std::size_t strip, std::vector<std::size_t>& next)
    : all_(all), strip_(strip), next_(next), row_(all.row_.data()), slot_(all.slot_.data()),
      block_of_window_(all.block_of_window_.data()) {
    next.resize(all.blocks_.size());
    for (std::size_t r = all.sent_[strip]; r < all.sent_[strip + 1]; ++r) next[all.route_[r].to] = all.route_[r].begin;
}

DeferredLoads::Deferring::~Deferring() {
    for (std::size_t r = all_.sent_[strip_]; r < all_.sent_[strip_ + 1]; ++r)
        all_.route_[r].end = next_[all_.route_[r].to];
}

} // namespace skein
