// Sums of doubles over all ranks with the same bits for any distribution and order of the terms. Each term is rounded
// once, to a multiple of a quantum that depends on the largest term of all; the rest is integer arithmetic. Error: at
// most half a quantum, 2^-86 of the largest term, per term. Cost: two collectives for all columns together.
#pragma once

#include "core/binned_sum.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

/// Sum of every column over the terms of all ranks. All ranks pass the same number of columns, each with any number of
/// terms (in all fewer than 2^40). A sum with NaN, or with infinities of both signs, is NaN; one with infinities of one
/// sign is that.
std::vector<double> exact_sums(const Communicator& comm, std::span<const std::vector<double>> columns);

/// Totals of all ranks, the same on each for any distribution of the terms.
std::vector<BinnedTotal> totals(const Communicator& comm, std::span<const BinnedTotal> mine);

/// Numbers row by row; each row is of a group.
struct Table {
    const double* first;
    std::size_t rows, columns, stride; ///< numbers from a row to the next
    std::size_t groups = 1;
    const std::uint32_t* group = nullptr; ///< by row; null: of the first
};
/// Sums of a table's columns by groups [group][column]; rows are shared out to threads.
std::vector<double> exact_sums(const Communicator& comm, const Threads& threads, const Table& terms);

} // namespace skein
