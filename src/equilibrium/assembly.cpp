#include "equilibrium/assembly.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

void Assembly::begin(int count) {
    same_ = count == count_ && matrix_.nonZeros() > 0;
    count_ = count;
    at_ = 0;
    entry_.clear();
    if (!same_) key_.clear();
    else std::fill_n(value_, matrix_.nonZeros(), 0.0);
}

void Assembly::find_pattern() {
    std::vector<Eigen::Triplet<double>> triplets;
    triplets.reserve(key_.size());
    const auto row_of = [](std::uint64_t key) { return static_cast<int>(key & 0xffffffff); };
    const auto column_of = [](std::uint64_t key) { return static_cast<int>(key >> 32); };
    for (const std::uint64_t key : key_) triplets.emplace_back(row_of(key), column_of(key), 0.0);
    matrix_.resize(count_, count_);
    matrix_.setFromTriplets(triplets.begin(), triplets.end());
    value_ = matrix_.valuePtr();
    const int* first = matrix_.outerIndexPtr();
    const int* row = matrix_.innerIndexPtr();
    const auto find = [&](int i, int j) {
        const int* end = row + first[j + 1];
        const int* at = std::lower_bound(row + first[j], end, i);
        return at != end && *at == i ? static_cast<int>(at - row) : -1;
    };
    place_.resize(key_.size());
    for (std::size_t e = 0; e < key_.size(); ++e) place_[e] = find(row_of(key_[e]), column_of(key_[e]));
    transposed_.resize(static_cast<std::size_t>(matrix_.nonZeros()));
    for (int j = 0; j < count_; ++j)
        for (int at = first[j]; at < first[j + 1]; ++at) transposed_[static_cast<std::size_t>(at)] = find(j, row[at]);
}

Stiffness& Assembly::finish() {
    if (same_ && at_ == key_.size()) return matrix_;
    key_.resize(at_);
    find_pattern();
    for (std::size_t e = 0; e < entry_.size(); ++e) value_[place_[e]] += entry_[e];
    return matrix_;
}

double Assembly::asymmetry() const {
    double largest = 0, difference = 0;
    for (std::size_t at = 0; at < transposed_.size(); ++at) {
        largest = std::max(largest, std::abs(value_[at]));
        const double other = transposed_[at] < 0 ? 0 : value_[transposed_[at]];
        difference = std::max(difference, std::abs(value_[at] - other));
    }
    return largest > 0 ? difference / largest : 0;
}

} // namespace skein
