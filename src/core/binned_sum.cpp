#include "core/binned_sum.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

SumBins::SumBins(double largest) {
    constexpr int least = -850; // units are normal numbers from here on
    const int exponent = largest > 0 && std::isfinite(largest) ? std::max(least, std::ilogb(largest)) : 0;
    for (int i = 0; i < count; ++i) {
        unit_[i] = std::ldexp(1.0, exponent - bits * (i + 1));
        rounder_[i] = std::ldexp(1.5, 52) * unit_[i];
    }
}

BinnedTotal BinnedTotal::of(std::span<const double, parts> numbers) const {
    BinnedTotal total = *this;
    total.count_ = {};
    total.other_ = 0;
    for (std::size_t i = 0; i < parts; ++i) total.add_at(i, numbers[i]);
    total.carry();
    return total;
}

double BinnedTotal::unit(std::size_t part) const {
    return std::ldexp(unit_, SumBins::bits * static_cast<int>(parts - 1 - part));
}

void BinnedTotal::add(const BinnedSum<double>& sum) {
    for (std::size_t i = 1; i < parts; ++i) add_at(i, sum.part[i - 1]);
    carry();
}

void BinnedTotal::add_at(std::size_t part, double x) {
    const double units = x / unit(part);
    if (std::abs(units) < 0x1p62) count_[part] += static_cast<std::int64_t>(units);
    else other_ += x;
}

void BinnedTotal::add(double x, const SumBins& bins) {
    BinnedSum<double> sum;
    sum.add(x, bins);
    add(sum);
}

void BinnedTotal::add(const BinnedTotal& other) {
    for (std::size_t i = 0; i < parts; ++i) count_[i] += other.count_[i];
    other_ += other.other_;
    carry();
}

/// Numbers of a total after the first are brought to at most 2^39 units.
void BinnedTotal::carry() {
    constexpr std::int64_t whole = std::int64_t(1) << SumBins::bits;
    for (std::size_t i = parts - 1; i > 0; --i) {
        const std::int64_t carried = (count_[i] + whole / 2) >> SumBins::bits;
        count_[i] -= carried * whole;
        count_[i - 1] += carried;
    }
}

std::array<double, BinnedTotal::parts> BinnedTotal::numbers() const {
    std::array<double, parts> all;
    for (std::size_t i = 0; i < parts; ++i) all[i] = static_cast<double>(count_[i]) * unit(i);
    all.front() += other_;
    return all;
}

double BinnedTotal::value() const {
    const auto all = numbers();
    double sum = 0;
    for (std::size_t i = parts; i-- > 0;) sum += all[i];
    return sum;
}

} // namespace skein
