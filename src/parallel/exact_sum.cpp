#include "parallel/exact_sum.hpp"

#include "parallel/blocks.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace skein {

namespace {

using Fixed = __int128;

// |term| < 2^86 quanta, so 2^40 terms stay below 2^126.
constexpr int term_bits = 86;

// A 128-bit integer in pieces whose sums over 2^31 ranks fit int64: three unsigned ones of 32 bits, and the signed
// rest.
constexpr int limbs = 4;
using Limbs = std::array<std::int64_t, limbs>;

Limbs split(Fixed value) {
    Limbs parts;
    for (auto& part : parts) {
        part = static_cast<std::int64_t>(value & 0xffffffff);
        value >>= 32;
    }
    parts[limbs - 1] = static_cast<std::int32_t>(parts[limbs - 1]);
    return parts;
}

Fixed join(std::span<const std::int64_t> parts) {
    Fixed value = 0;
    for (int i = limbs - 1; i >= 0; --i) value = value * (Fixed(1) << 32) + nth(parts, i);
    return value;
}

/// Range of a column on all ranks.
enum Property { largest, has_nan, has_plus_infinity, has_minus_infinity, properties };

using Found = std::array<double, properties>;

void inspect(Found& found, double x) {
    if (std::isfinite(x)) found[largest] = std::max(found[largest], std::abs(x));
    else found[std::isnan(x) ? has_nan : x > 0 ? has_plus_infinity : has_minus_infinity] = 1;
}

/// log2 of the number of quanta in 1.
int quantum_shift(double largest_term) { return largest_term > 0 ? term_bits - 1 - std::ilogb(largest_term) : 0; }

/// x 2^shift, |x| < 2^86 quanta, rounded to the nearest whole number, to even where two are as near.
Fixed in_quanta(double x, int shift) {
    constexpr int fraction_bits = 52, bias = 1075; // mantissa as a whole number
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const int exponent = static_cast<int>(bits >> fraction_bits & 0x7ff);
    const std::uint64_t fraction = bits & ((1ull << fraction_bits) - 1),
                        mantissa = exponent > 0 ? fraction | 1ull << fraction_bits : fraction;
    const int power = std::max(exponent, 1) - bias + shift;
    Fixed whole = 0;
    if (power >= 0) {
        whole = static_cast<Fixed>(mantissa) << power;
    } else if (power >= -fraction_bits - 1) {
        const std::uint64_t half = 1ull << (-power - 1), rest = mantissa & (2 * half - 1);
        const std::uint64_t below = mantissa >> -power;
        whole = static_cast<Fixed>(below + (rest > half || (rest == half && (below & 1)) ? 1 : 0));
    }
    return bits >> 63 ? -whole : whole;
}

/// Sums of columns over all ranks, of their properties and their sums in quanta on this one.
std::vector<double> sums_of(const Communicator& comm, std::vector<Found> mine, const auto& fixed_sums) {
    std::vector<double> found;
    for (const Found& column : mine) found.insert(found.end(), column.begin(), column.end());
    comm.max(found);

    const auto shift = [&](std::size_t c) { return quantum_shift(found[c * properties + largest]); };
    std::vector<int> shifts;
    for (std::size_t c = 0; c < mine.size(); ++c) shifts.push_back(shift(c));
    std::vector<std::int64_t> parts;
    for (const Fixed sum : fixed_sums(shifts)) {
        const auto split_sum = split(sum);
        parts.insert(parts.end(), split_sum.begin(), split_sum.end());
    }
    comm.sum(parts);

    std::vector<double> sums(mine.size());
    for (std::size_t c = 0; c < sums.size(); ++c) {
        const auto column = std::span(found).subspan(c * properties, properties);
        const double infinity = std::numeric_limits<double>::infinity();
        if (column[has_nan] > 0 || (column[has_plus_infinity] > 0 && column[has_minus_infinity] > 0))
            sums[c] = std::numeric_limits<double>::quiet_NaN();
        else if (column[has_plus_infinity] > 0) sums[c] = infinity;
        else if (column[has_minus_infinity] > 0) sums[c] = -infinity;
        else sums[c] = std::ldexp(static_cast<double>(join(std::span(parts).subspan(c * limbs, limbs))), -shifts[c]);
    }
    return sums;
}

} // namespace

std::vector<double> exact_sums(const Communicator& comm, std::span<const std::vector<double>> columns) {
    std::vector<Found> found(columns.size(), Found{});
    for (std::size_t c = 0; c < columns.size(); ++c)
        for (const double x : columns[c]) inspect(found[c], x);
    return sums_of(comm, found, [&](std::span<const int> shifts) {
        std::vector<Fixed> sums(columns.size());
        for (std::size_t c = 0; c < columns.size(); ++c)
            for (const double x : columns[c])
                if (std::isfinite(x)) sums[c] += in_quanta(x, shifts[c]);
        return sums;
    });
}

std::vector<double> exact_sums(const Communicator& comm, const Threads& threads, const Table& terms) {
    const std::size_t sums_in_all = terms.groups * terms.columns;
    /// each(thread, sum, term)
    const auto for_terms = [&](auto&& each) {
        threads.for_each(blocks_of(terms.rows), [&](std::size_t block, int thread) {
            const std::size_t end = std::min(terms.rows, (block + 1) * block_size);
            for (std::size_t row = block * block_size; row < end; ++row) {
                const std::size_t first = terms.group ? terms.group[row] * terms.columns : 0;
                for (std::size_t c = 0; c < terms.columns; ++c)
                    each(to_index(thread), first + c, terms.first[row * terms.stride + c]);
            }
        });
    };
    const auto count = to_index(threads.count());
    std::vector<std::vector<Found>> found(count, std::vector<Found>(sums_in_all, Found{}));
    for_terms([&](std::size_t thread, std::size_t sum, double term) { inspect(found[thread][sum], term); });
    for (const auto& of_thread : found)
        for (std::size_t s = 0; s < sums_in_all; ++s)
            for (int p = 0; p < properties; ++p) found[0][s][p] = std::max(found[0][s][p], of_thread[s][p]);
    return sums_of(comm, found[0], [&](std::span<const int> shifts) {
        std::vector<std::vector<Fixed>> sums(count, std::vector<Fixed>(sums_in_all));
        for_terms([&](std::size_t thread, std::size_t sum, double term) {
            if (std::isfinite(term)) sums[thread][sum] += in_quanta(term, shifts[sum]);
        });
        for (std::size_t thread = 1; thread < count; ++thread)
            for (std::size_t s = 0; s < sums_in_all; ++s) sums[0][s] += sums[thread][s];
        return sums[0];
    });
}

std::vector<BinnedTotal> totals(const Communicator& comm, std::span<const BinnedTotal> mine) {
    std::vector<std::vector<double>> columns; // whole multiples of units: their sums are exact
    for (const BinnedTotal& total : mine)
        for (const double part : total.numbers()) columns.push_back({part});
    const std::vector<double> sums = exact_sums(comm, columns);
    std::vector<BinnedTotal> all;
    for (std::size_t i = 0; i < mine.size(); ++i)
        all.push_back(
            mine[i].of(std::span<const double, BinnedTotal::parts>(&sums[i * BinnedTotal::parts], BinnedTotal::parts)));
    return all;
}

} // namespace skein
