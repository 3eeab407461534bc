// Loops over many small things, such as rods, in pieces that threads share.
#pragma once

#include "parallel/threads.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <vector>

namespace skein {

/// Number of threads in a loop; null: one.
inline std::size_t threads_in(const Threads* threads) {
    return threads ? static_cast<std::size_t>(threads->count()) : 1;
}

/// body(begin, end, thread, piece) for pieces of [0, n) with `size` numbers, the last one with fewer. Of several
/// exceptions the first piece's is thrown, as if pieces came one after another.
template <class Body> void in_pieces(const Threads* threads, std::size_t n, std::size_t size, Body&& body) {
    const std::size_t pieces = (n + size - 1) / size;
    const auto call = [&](std::size_t piece, int thread) {
        body(piece * size, std::min(n, (piece + 1) * size), static_cast<std::size_t>(thread), piece);
    };
    if (!threads || threads->count() == 1) {
        for (std::size_t piece = 0; piece < pieces; ++piece) call(piece, 0);
        return;
    }
    std::vector<std::exception_ptr> faults(pieces);
    threads->for_each(pieces, [&](std::size_t piece, int thread) {
        try {
            call(piece, thread);
        } catch (...) {
            faults[piece] = std::current_exception();
        }
    });
    const auto first = std::find_if(faults.begin(), faults.end(), [](const auto& fault) { return fault != nullptr; });
    if (first != faults.end()) std::rethrow_exception(*first);
}

} // namespace skein
