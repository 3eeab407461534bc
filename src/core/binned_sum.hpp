// Sums with the same bits for any order and grouping of the terms, at the cost of some additions a term: each is split
// into whole multiples of three units, 2^40 apart, whose sums are exact. What is left of a term, half of the last unit
// at most, is rounded once and for itself. Binned summation: Ahrens, Demmel, Nguyen, ACM Trans. Math. Softw. 46 (2020)
// 22; here with units that do not depend on the terms.
#pragma once

#include "skein/core/pack.hpp"

#include <array>
#include <cstdint>
#include <span>

namespace skein {

/// Units of a sum: 2^-40, 2^-80 and 2^-120 of the power of two at or below `largest`, which terms hardly exceed; of a
/// number that is not positive and finite those of 1. Sums of 2^13 such terms are exact before they go into a total.
class SumBins {
public:
    static constexpr int count = 3, bits = 40;

    explicit SumBins(double largest);
    double unit(int i) const { return unit_[i]; }
    /// Rounds to multiples of a unit: (x + r) - r.
    double rounder(int i) const { return rounder_[i]; }

private:
    double unit_[count], rounder_[count];
};

/// Terms that have been split, lane by lane.
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

/// A sum without bounds for the number of terms, up to 2^53 times the largest.
class BinnedTotal {
public:
    static constexpr std::size_t parts = SumBins::count + 1;

    explicit BinnedTotal(const SumBins& bins) : unit_(bins.unit(SumBins::count - 1)) {}
    /// In the same units, of the numbers of a total or of their sums over the totals of up to 2^13 ranks.
    BinnedTotal of(std::span<const double, parts> numbers) const;

    void add(const BinnedSum<double>& sum);
    void add(double x, const SumBins& bins);
    void add(const BinnedTotal& other);
    /// Parts of falling size, of which any is a whole multiple of a unit: the same for the same sum.
    std::array<double, parts> numbers() const;
    double value() const;
    friend bool operator==(const BinnedTotal&, const BinnedTotal&) = default;

private:
    double unit(std::size_t part) const;
    void add_at(std::size_t part, double x);
    void carry();

    double unit_;                             ///< the last one
    std::array<std::int64_t, parts> count_{}; ///< of units, falling by 2^40
    double other_ = 0;                        ///< terms that are not finite or beyond all bounds
};

} // namespace skein
