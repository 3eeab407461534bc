// What weights of regularised deltas must be, wherever the marker is between grid points.
#include "immersion/delta.hpp"
#include "skein/core/index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace skein {
namespace {

constexpr DeltaKind all_kinds[] = {DeltaKind::three_point, DeltaKind::four_point};

TEST(Delta, SumsToOneAndStandsWhereTheMarkerIs) {
    for (const DeltaKind kind : all_kinds)
        for (int i = -400; i <= 400; ++i) {
            const double place = 0.0137 * i;
            const DeltaWeights w = delta_weights(kind, place);
            double sum = 0, moment = 0, squares = 0;
            for (int p = 0; p < w.count; ++p) {
                const double weight = nth(w.weight, p);
                EXPECT_GE(weight, -1e-15);
                sum += weight;
                moment += weight * (w.first + p - place);
                squares += weight * weight;
            }
            EXPECT_NEAR(sum, 1, 1e-14);
            EXPECT_NEAR(moment, 0, 1e-14);
            EXPECT_NEAR(squares, kind == DeltaKind::three_point ? 0.5 : 0.375, 1e-14) << "the same wherever it is";
        }
}

/// Weight of a point so far from the marker, as the references of (80) have it.
double published(DeltaKind kind, double distance) {
    const double r = std::abs(distance), none = 0;
    if (kind == DeltaKind::three_point) {
        if (r < 0.5) return (1 + std::sqrt(1 - 3 * r * r)) / 3;
        return r < 1.5 ? (5 - 3 * r - std::sqrt(std::max(none, 1 - 3 * (1 - r) * (1 - r)))) / 6 : 0;
    }
    if (r < 1) return (3 - 2 * r + std::sqrt(std::max(none, 1 + 4 * r - 4 * r * r))) / 8;
    return r < 2 ? (5 - 2 * r - std::sqrt(std::max(none, -7 + 12 * r - 4 * r * r))) / 8 : 0;
}

TEST(Delta, IsThePublishedFunctionAndLeavesNoPointOut) {
    for (const DeltaKind kind : all_kinds)
        for (int i = -300; i <= 300; ++i) {
            const double place = 0.01 * i;
            const DeltaWeights w = delta_weights(kind, place);
            for (int point = w.first - 2; point < w.first + w.count + 2; ++point) {
                const bool has = point >= w.first && point < w.first + w.count;
                EXPECT_NEAR(has ? nth(w.weight, point - w.first) : 0.0, published(kind, place - point), 1e-15)
                    << place << ' ' << point;
            }
        }
}

} // namespace
} // namespace skein
