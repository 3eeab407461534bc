// What weights of regularised deltas must be, wherever the marker is between grid points.
#include "immersion/delta.hpp"

#include <gtest/gtest.h>

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
                const double weight = w.weight[static_cast<std::size_t>(p)];
                EXPECT_GE(weight, -1e-15);
                sum += weight, moment += weight * (w.first + p - place), squares += weight * weight;
            }
            EXPECT_NEAR(sum, 1, 1e-14);
            EXPECT_NEAR(moment, 0, 1e-14);
            EXPECT_NEAR(squares, kind == DeltaKind::three_point ? 0.5 : 0.375, 1e-14) << "the same wherever it is";
        }
}

TEST(Delta, LeavesNoPointOut) {
    for (const DeltaKind kind : all_kinds)
        for (int i = 0; i < 100; ++i) {
            const double place = 0.01 * i;
            const DeltaWeights w = delta_weights(kind, place);
            EXPECT_NEAR(delta_at(kind, place - (w.first - 1)), 0, 1e-15);
            EXPECT_NEAR(delta_at(kind, place - (w.first + w.count)), 0, 1e-15);
        }
}

} // namespace
} // namespace skein
