// Binned sums: the same bits for any order and grouping of the terms. Each term is split into whole multiples of three
// units, 2^40 apart, whose sums are exact. The rest, at most half of the last unit, is rounded once. Source: Ahrens,
// Demmel, Nguyen, ACM Trans. Math. Softw. 46 (2020) 22; here the units do not depend on the terms.
#pragma once

#include "skein/core/pack.hpp"

#include <array>
#include <cstdint>
#include <span>

namespace skein {

/// Units of a sum: 2^-40, 2^-80 and 2^-120 of the power of two at or below `largest`, which terms hardly exceed. A
/// `largest` that is not positive and finite counts as 1. Sums of 2^13 such terms are exact before they enter a total.
class SumBins {
public:
    static constexpr int count = 3, bits = 40;

    explicit SumBins(double largest);
    double unit(int i) const { return unit_[i]; }
    /// Rounder r of part i: (x + r) - r is x rounded to a multiple of its unit.
    double rounder(int i) const { return rounder_[i]; }

private:
    double unit_[count], rounder_[count];
};

/// Sums of split terms, lane by lane.
template <class P> struct BinnedSum {
    P part[SumBins::count] = {P(0.0), P(0.0), P(0.0)};

    SKEIN_INLINE void add(P x, const SumBins& bins) {
        for (int i = 0; i < SumBins::count; ++i) {
            const P rounder(bins.rounder(i)), multiple = (x + rounder) - rounder;
            part[i] += multiple;
            x = x - multiple;
        }
    }
};

/// Sum of any number of terms, up to 2^53 times the largest.
class BinnedTotal {
public:
    static constexpr std::size_t parts = SumBins::count + 1;

    explicit BinnedTotal(const SumBins& bins) : unit_(bins.unit(SumBins::count - 1)) {}
    /// Total in the same units, from the numbers of one total, or from their sums over the totals of up to 2^13 ranks.
    BinnedTotal of(std::span<const double, parts> numbers) const;

    void add(const BinnedSum<double>& sum);
    void add(double x, const SumBins& bins);
    void add(const BinnedTotal& other);
    /// Parts of falling size, each a whole multiple of a unit. Equal sums have equal parts.
    std::array<double, parts> numbers() const;
    double value() const;
    friend bool operator==(const BinnedTotal&, const BinnedTotal&) = default;

private:
    double unit(std::size_t part) const;
    void add_at(std::size_t part, double x);
    void carry();

    double unit_;                             ///< last unit
    std::array<std::int64_t, parts> count_{}; ///< numbers of units, falling by 2^40
    double other_ = 0;                        ///< sum of the terms that are not finite or beyond all bounds
};

} // namespace skein
