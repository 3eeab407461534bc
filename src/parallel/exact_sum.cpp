#include "parallel/exact_sum.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace skein {

namespace {

using Fixed = __int128;

// |term| < 2^86 quanta, so 2^40 terms stay below 2^126.
constexpr int term_bits = 86;

// A 128-bit integer in pieces whose sums over 2^31 ranks fit int64: three unsigned ones of 32 bits, and the signed rest.
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
    for (int i = limbs - 1; i >= 0; --i) value = value * (Fixed(1) << 32) + parts[static_cast<std::size_t>(i)];
    return value;
}

/// What a column holds on all ranks.
enum Property { largest, has_nan, has_plus_infinity, has_minus_infinity, properties };

std::array<double, properties> inspect(std::span<const double> terms) {
    std::array<double, properties> found{};
    for (const double x : terms) {
        if (std::isfinite(x)) found[largest] = std::max(found[largest], std::abs(x));
        else found[std::isnan(x) ? has_nan : x > 0 ? has_plus_infinity : has_minus_infinity] = 1;
    }
    return found;
}

/// log2 of the number of quanta in 1.
int quantum_shift(double largest_term) { return largest_term > 0 ? term_bits - 1 - std::ilogb(largest_term) : 0; }

Fixed fixed_sum(std::span<const double> terms, int shift) {
    Fixed sum = 0;
    for (const double x : terms)
        if (std::isfinite(x)) sum += static_cast<Fixed>(std::nearbyint(std::ldexp(x, shift)));
    return sum;
}

} // namespace

std::vector<double> exact_sums(const Communicator& comm, std::span<const std::vector<double>> columns) {
    std::vector<double> found;
    for (const auto& column : columns) {
        const auto mine = inspect(column);
        found.insert(found.end(), mine.begin(), mine.end());
    }
    comm.max(found);

    std::vector<std::int64_t> parts;
    for (std::size_t c = 0; c < columns.size(); ++c) {
        const auto mine = split(fixed_sum(columns[c], quantum_shift(found[c * properties + largest])));
        parts.insert(parts.end(), mine.begin(), mine.end());
    }
    comm.sum(parts);

    std::vector<double> sums(columns.size());
    for (std::size_t c = 0; c < columns.size(); ++c) {
        const auto column = std::span(found).subspan(c * properties, properties);
        const double infinity = std::numeric_limits<double>::infinity();
        if (column[has_nan] > 0 || (column[has_plus_infinity] > 0 && column[has_minus_infinity] > 0))
            sums[c] = std::numeric_limits<double>::quiet_NaN();
        else if (column[has_plus_infinity] > 0) sums[c] = infinity;
        else if (column[has_minus_infinity] > 0) sums[c] = -infinity;
        else
            sums[c] =
                std::ldexp(static_cast<double>(join(std::span(parts).subspan(c * limbs, limbs))), -quantum_shift(column[largest]));
    }
    return sums;
}

} // namespace skein
