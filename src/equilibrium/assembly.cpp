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
    const auto row_of = [](std::uint64_t key) { return static_cast<int>(key & 0xffffffff); };
    const auto column_of = [](std::uint64_t key) { return static_cast<std::size_t>(key >> 32); };
    // Entries column by column, in their order; rows of a column mostly rise.
    const auto columns = static_cast<std::size_t>(count_);
    std::vector<std::size_t> end(columns + 1, 0), order(key_.size());
    for (const std::uint64_t key : key_) ++end[column_of(key) + 1];
    for (std::size_t j = 0; j < columns; ++j) end[j + 1] += end[j];
    std::vector<std::size_t> next(end.begin(), end.end() - 1);
    for (std::size_t e = 0; e < key_.size(); ++e) order[next[column_of(key_[e])]++] = e;
    std::vector<int> first(columns + 1, 0), rows, own;
    rows.reserve(key_.size());
    place_.resize(key_.size());
    for (std::size_t j = 0; j < columns; ++j) {
        own.clear();
        for (std::size_t at = end[j]; at < end[j + 1]; ++at) own.push_back(row_of(key_[order[at]]));
        if (!std::is_sorted(own.begin(), own.end())) std::sort(own.begin(), own.end());
        own.erase(std::unique(own.begin(), own.end()), own.end());
        for (std::size_t at = end[j]; at < end[j + 1]; ++at) {
            const auto found = std::lower_bound(own.begin(), own.end(), row_of(key_[order[at]]));
            place_[order[at]] = first[j] + static_cast<int>(found - own.begin());
        }
        rows.insert(rows.end(), own.begin(), own.end());
        first[j + 1] = static_cast<int>(rows.size());
    }
    const std::vector<double> none(rows.size(), 0.0);
    matrix_ = Eigen::Map<const Stiffness>(count_, count_, static_cast<Eigen::Index>(rows.size()), first.data(),
                                          rows.data(), none.data());
    value_ = matrix_.valuePtr();
    find_transposed();
}

/// Places of K_ji: row i of the columns j = 0, 1, ... in turn, where the pattern is that of its transposed.
void Assembly::find_transposed() {
    const int *first = matrix_.outerIndexPtr(), *row = matrix_.innerIndexPtr();
    std::vector<int> next(first, first + count_);
    transposed_.resize(static_cast<std::size_t>(matrix_.nonZeros()));
    for (int j = 0; j < count_; ++j)
        for (int at = first[j]; at < first[j + 1]; ++at) {
            const auto i = static_cast<std::size_t>(row[at]);
            while (next[i] < first[i + 1] && row[next[i]] < j) ++next[i];
            const bool there = next[i] < first[i + 1] && row[next[i]] == j;
            transposed_[static_cast<std::size_t>(at)] = there ? next[i]++ : -1;
        }
}

Stiffness& Assembly::finish() {
    if (same_ && at_ == key_.size()) return matrix_;
    key_.resize(at_);
    find_pattern();
    for (std::size_t e = 0; e < entry_.size(); ++e) value_[place_[e]] += entry_[e];
    return matrix_;
}

void Assembly::take_symmetric_part() {
    for (std::size_t at = 0; at < transposed_.size(); ++at) {
        const int other = transposed_[at];
        if (other < static_cast<int>(at)) continue; // done, or none
        value_[at] = value_[other] = 0.5 * (value_[at] + value_[other]);
    }
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
