// Regularised delta functions of one dimension: weights of the grid points near a marker. Their sum is 1, and their
// first moment is the place of the marker. theory.md (80)
#pragma once

#include <array>
#include <cmath>
#include <string_view>

namespace skein {

enum class DeltaKind { three_point, four_point };
inline constexpr std::string_view delta_names[] = {"three_point", "four_point"};

/// Weights of the points first, first + 1, ... for a place in units of the spacing, measured from point 0.
struct DeltaWeights {
    static constexpr int most = 4;
    int first = 0, count = 0;
    std::array<double, most> weight{};
};

inline DeltaWeights delta_weights(DeltaKind kind, double place) {
    const bool three = kind == DeltaKind::three_point;
    const double base = std::floor(three ? place + 0.5 : place), r = place - base;
    DeltaWeights w;
    w.first = static_cast<int>(base) - 1;
    w.count = three ? 3 : 4;
    if (three) {
        const double root = std::sqrt(1 - 3 * r * r); // |r| <= 1/2
        w.weight = {(2 - 3 * r - root) / 6, (1 + root) / 3, (2 + 3 * r - root) / 6, 0};
    } else {
        const double root = std::sqrt(1 + 4 * r * (1 - r)); // 0 <= r < 1
        w.weight = {(3 - 2 * r - root) / 8, (3 - 2 * r + root) / 8, (1 + 2 * r + root) / 8, (1 + 2 * r - root) / 8};
    }
    return w;
}

} // namespace skein
