// Regularised delta functions of one dimension: weights of the grid points near a marker, which are 1 in sum and whose first moment
// is the place of the marker.                                                                                         theory.md
// (80)
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace skein {

enum class DeltaKind { three_point, four_point };
inline constexpr std::string_view delta_names[] = {"three_point", "four_point"};

/// Weights of points first, first + 1, ...; of a place in units of the spacing, from that of point 0.
struct DeltaWeights {
    static constexpr int most = 4;
    int first = 0, count = 0;
    std::array<double, most> weight{};
};

inline double delta_at(DeltaKind kind, double distance) {
    const double r = std::abs(distance), none = 0;
    if (kind == DeltaKind::three_point) {
        if (r < 0.5) return (1 + std::sqrt(1 - 3 * r * r)) / 3;
        return r < 1.5 ? (5 - 3 * r - std::sqrt(std::max(none, 1 - 3 * (1 - r) * (1 - r)))) / 6 : 0;
    }
    if (r < 1) return (3 - 2 * r + std::sqrt(std::max(none, 1 + 4 * r - 4 * r * r))) / 8;
    return r < 2 ? (5 - 2 * r - std::sqrt(std::max(none, -7 + 12 * r - 4 * r * r))) / 8 : 0;
}

inline DeltaWeights delta_weights(DeltaKind kind, double place) {
    DeltaWeights w;
    w.count = kind == DeltaKind::three_point ? 3 : 4;
    w.first = static_cast<int>(kind == DeltaKind::three_point ? std::floor(place + 0.5) - 1 : std::floor(place) - 1);
    for (int i = 0; i < w.count; ++i) w.weight[static_cast<std::size_t>(i)] = delta_at(kind, place - (w.first + i));
    return w;
}

} // namespace skein
