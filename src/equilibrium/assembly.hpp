// Sparse stiffness from its entries, whose places are found once for all matrices of one pattern.
#pragma once

#include "equilibrium/factor.hpp"

#include <cstdint>
#include <vector>

namespace skein {

class Assembly {
public:
    /// Begins the next matrix of `count` unknowns.
    void begin(int count);
    void add(int row, int column, double value) {
        const std::uint64_t key = static_cast<std::uint64_t>(column) << 32 | static_cast<std::uint32_t>(row);
        if (same_ && at_ < key_.size() && key_[at_] == key) {
            value_[place_[at_]] += value;
        } else {
            if (same_) key_.resize(at_);
            same_ = false;
            key_.push_back(key);
        }
        entry_.push_back(value);
        ++at_;
    }
    /// The sum of all entries since then, in their order. It stays until the next begin().
    Stiffness& finish();
    double asymmetry() const; ///< largest |K - K^T| over the largest |K|
    /// Leaves (K + K^T)/2, if the pattern has K_ji for each K_ij.
    void take_symmetric_part();

private:
    void find_pattern();
    void find_transposed();

    int count_ = 0;
    bool same_ = false; ///< as far as the entries before
    std::size_t at_ = 0;
    std::vector<std::uint64_t> key_; ///< column and row of each entry
    std::vector<double> entry_;
    std::vector<int> place_;      ///< of each entry among the values
    std::vector<int> transposed_; ///< place of K_ji for K_ij; -1: none
    double* value_ = nullptr;
    Stiffness matrix_;
};

} // namespace skein
