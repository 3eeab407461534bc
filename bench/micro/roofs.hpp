// What a core can do: fused multiply-adds from registers at every width, and streams through arrays that fill a level
// of the memory.
#pragma once

#include "skein/core/aligned.hpp"
#include "skein/core/pack.hpp"

#include <benchmark/benchmark.h>

#include <cstddef>

namespace skein::bench {

/// Of a row, per element: what its time is set against.
inline void set_cost(benchmark::State& state, double elements, double flop, double bytes, double working_set) {
    state.counters["s"] =
        benchmark::Counter(elements, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    state.counters["flop"] = flop;
    state.counters["bytes"] = bytes;
    state.counters["working_set"] = working_set;
}

/// Twelve independent chains of fused multiply-adds in registers.
template <int W> void run_peak(benchmark::State& state) {
    using P = Pack<W>;
    constexpr int chains = 12, links = 100;
    P x[chains];
    for (int i = 0; i < chains; ++i) x[i] = P(1.0 + 0.01 * i);
    const P a(0.999), b(0.001);
    for (auto _ : state) {
        for (int link = 0; link < links; ++link)
            for (int i = 0; i < chains; ++i) x[i] = fma(x[i], a, b);
        benchmark::DoNotOptimize(x);
    }
    set_cost(state, 1.0 * chains * links * W, 2, 0, 0);
}

/// Records of `Read` lines of which `Written` are changed in place, a <- s a + s: update is 8 of 8; a rotation of
/// frames 4 of 7, a step 13 of 13.
template <int Read, int Written> void run_update(benchmark::State& state, double bytes) {
    using P = Pack<8>;
    const auto records = static_cast<std::size_t>(bytes / (Read * sizeof(P)));
    AlignedVector<P> a(records * Read, P(1.0));
    const P s(0.5);
    for (auto _ : state) {
        P sum(0.0);
        for (std::size_t i = 0; i < a.size(); i += Read) {
            for (int k = Written; k < Read; ++k) sum += a[i + static_cast<std::size_t>(k)];
            for (int k = 0; k < Written; ++k)
                a[i + static_cast<std::size_t>(k)] = fma(s, a[i + static_cast<std::size_t>(k)], s);
        }
        benchmark::DoNotOptimize(sum);
        benchmark::ClobberMemory();
    }
    set_cost(state, static_cast<double>(records) * 8, 2.0 * Written + Read - Written, 8.0 * (Read + Written),
             static_cast<double>(a.size() * sizeof(P)));
}

/// a <- b + s c in three arrays; counted without the reading of a that a cache makes of it.
inline void run_triad(benchmark::State& state, double bytes) {
    using P = Pack<8>;
    const auto count = static_cast<std::size_t>(bytes / (3 * 4 * sizeof(P))) * 4;
    AlignedVector<P> a(count, P(0.0)), b(count, P(1.0)), c(count, P(2.0));
    const P s(0.5);
    for (auto _ : state) {
        for (std::size_t i = 0; i < count; i += 4)
            for (std::size_t k = i; k < i + 4; ++k) a[k] = fma(s, c[k], b[k]);
        benchmark::ClobberMemory();
    }
    set_cost(state, static_cast<double>(count) * 8, 2, 24, static_cast<double>(3 * count * sizeof(P)));
}

} // namespace skein::bench
