#include "immersion/sweep_shares.hpp"

#include "skein/core/index.hpp"

#include <cmath>
#include <cstdint>

namespace skein {

/// Shares a_j of n sweeps. Of a slip from which one sweep takes the share l, they leave the Bernstein polynomial of
/// max(0, 1 - 3 l):
///     1 - l sum_j a_j (1 - l)^j = sum_k max(0, 1 - 3 k/n) C(n, k) l^k (1 - l)^(n - k).
std::vector<double> sweep_shares(int sweeps) {
    const int n = sweeps, bound = most_plain_sweeps;
    std::vector<double> shares(to_index(n), 1.0);
    if (n <= bound) return shares;
    std::vector<std::int64_t> left(to_index(n + 1), 0); // n times the coefficients of (1 - l)^i
    std::int64_t choose = 1;                            // C(n, k)
    for (int k = 0; bound * k < n; choose = choose * (n - k) / (k + 1), ++k) {
        std::int64_t term = (n - bound * k) * choose; // l^k = sum_i C(k, i) (-1)^i (1 - l)^i
        for (int i = 0; i <= k; term = -term * (k - i) / (i + 1), ++i) nth(left, n - k + i) += term;
    }
    std::int64_t sum = n; // coefficients of (1 - polynomial)/l
    for (std::size_t j = 0; j < shares.size(); ++j) shares[j] = static_cast<double>(sum -= left[j]) / n;
    return shares;
}

} // namespace skein
