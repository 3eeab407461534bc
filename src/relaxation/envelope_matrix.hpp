// Symmetric positive definite matrix, of which each row is kept from its first entry to the diagonal. Factors of
// Cholesky have the same envelope: entries before it add nothing. Sums run in an order that has the same bits at every
// level of instructions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace skein {

class EnvelopeMatrix {
public:
    /// Adds a row of zeros whose first entry is in this column. Returns a pointer to its column 0, valid until the next
    /// row.
    double* add_row(std::size_t first) {
        const std::size_t row = first_.size();
        first_.push_back(first);
        begin_.push_back(entry_.size());
        entry_.resize(entry_.size() + row + 1 - first, 0.0);
        return at(row);
    }
    /// Replaces x by the solution for it, and the entries by those of the factors.
    void solve(std::vector<double>& x) {
        const std::size_t n = first_.size();
        for (std::size_t i = 0; i < n; ++i) factorise(i);
        for (std::size_t i = 0; i < n; ++i) {
            const double* const row = at(i);
            for (std::size_t m = first_[i]; m < i; ++m) x[i] -= row[m] * x[m];
            x[i] /= row[i];
        }
        for (std::size_t i = n; i-- > 0;) {
            const double* const row = at(i);
            x[i] /= row[i];
            for (std::size_t m = first_[i]; m < i; ++m) x[m] -= row[m] * x[i];
        }
    }

private:
    double* at(std::size_t row) { return entry_.data() + begin_[row] - first_[row]; }
    void factorise(std::size_t i) {
        double* const row = at(i);
        for (std::size_t j = first_[i]; j <= i; ++j) {
            const double* const other = at(j);
            for (std::size_t m = std::max(first_[i], first_[j]); m < j; ++m) row[j] -= row[m] * other[m];
            row[j] = j < i ? row[j] / other[j] : std::sqrt(row[j]);
        }
    }

    std::vector<std::size_t> first_, begin_; ///< by row: column of its first entry, and its place
    std::vector<double> entry_;
};

} // namespace skein
