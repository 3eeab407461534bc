// Rods across where they fill tiles, along where they do not; every rod has its place.
#include "skein/core/index.hpp"
#include "tiles/tiling.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace skein {
namespace {

/// Every pooled rod has a part, no tile more lanes than there are, no piece more rows than its tile.
void expect_complete(const Tiling& tiling, const std::vector<TilingGroup>& groups, int lanes) {
    std::vector<std::int64_t> seen = tiling.across;
    for (const AlongTile& tile : tiling.along) {
        int taken = 0;
        for (const AlongTile::Part& part : tile.parts) {
            const TilingGroup& g = nth(groups, part.group);
            EXPECT_EQ(g.family, tile.family);
            EXPECT_GE(part.pieces * tile.rows, g.elements);
            ++nth(seen, part.group);
            taken += part.pieces;
        }
        EXPECT_LE(taken, lanes);
    }
    for (std::size_t g = 0; g < groups.size(); ++g) EXPECT_EQ(seen[g], groups[g].rods);
}

TEST(Tiling, FullTilesLieAcross) {
    const std::vector<TilingGroup> groups = {{64, 25, 0}};
    const Tiling tiling = choose_tiling(groups, 8, 2);
    EXPECT_EQ(tiling.across[0], 64);
    EXPECT_TRUE(tiling.along.empty());
}

TEST(Tiling, ALoneRodFillsAllLanes) {
    for (const int lanes : {2, 4, 8}) {
        const std::vector<TilingGroup> groups = {{1, 200, 0}};
        const Tiling tiling = choose_tiling(groups, lanes, 2);
        expect_complete(tiling, groups, lanes);
        ASSERT_EQ(tiling.along.size(), 1u);
        EXPECT_EQ(tiling.along[0].parts[0].pieces, lanes);
        EXPECT_EQ(tiling.along[0].rows, 200 / lanes);
    }
}

TEST(Tiling, FewRodsKeepAllThreadsBusy) {
    const std::vector<TilingGroup> groups = {{8, 200, 0}};
    EXPECT_EQ(choose_tiling(groups, 8, 1).across[0], 8);
    const Tiling two = choose_tiling(groups, 8, 2);
    expect_complete(two, groups, 8);
    EXPECT_EQ(two.along.size(), 2u);
    EXPECT_EQ(two.along[0].rows, 100);
}

TEST(Tiling, RodsOfUnlikeLengthsShareTiles) {
    std::vector<TilingGroup> groups;
    std::int64_t elements = 0;
    for (int n = 5; n <= 100; ++n) {
        groups.push_back({1, n, 0});
        elements += n;
    }
    const Tiling tiling = choose_tiling(groups, 8, 1);
    expect_complete(tiling, groups, 8);
    int rows = 0;
    for (const AlongTile& tile : tiling.along) rows += tile.rows;
    EXPECT_LT(8 * rows, 1.12 * static_cast<double>(elements));
}

TEST(Tiling, FamiliesDoNotMixAndSomeGroupsStayAcross) {
    const std::vector<TilingGroup> groups = {{3, 20, 0}, {2, 20, 1}, {3, 20, -1}, {1, 40, 0}};
    for (const Mapping mapping : {Mapping::automatic, Mapping::along}) {
        const Tiling tiling = choose_tiling(groups, 8, 1, mapping);
        expect_complete(tiling, groups, 8);
        EXPECT_EQ(tiling.across[2], 3);
    }
    EXPECT_TRUE(choose_tiling(groups, 8, 1, Mapping::across).along.empty());
    EXPECT_TRUE(choose_tiling(groups, 1, 1, Mapping::along).along.empty());
}

TEST(Tiling, LongRodsAreCutToStayInCache) {
    const std::vector<TilingGroup> groups = {{800, 2000, 0}};
    const Tiling tiling = choose_tiling(groups, 8, 2);
    expect_complete(tiling, groups, 8);
    EXPECT_EQ(tiling.across[0], 0);
    for (const AlongTile& tile : tiling.along) EXPECT_LE(tile.rows, 600);
}

TEST(Tiling, RemaindersOfLargeGroupsShareTiles) {
    const std::vector<TilingGroup> groups = {{8003, 25, 0}, {8002, 30, 0}};
    const Tiling tiling = choose_tiling(groups, 8, 1);
    expect_complete(tiling, groups, 8);
    EXPECT_GE(tiling.across[0], 8000);
    EXPECT_GE(tiling.across[1], 8000);
}

/// Wide tiles would repeat them. Those that lie along fill all lanes.
TEST(Tiling, FewRodsAcrossTakeNarrowTiles) {
    const auto lanes = [](std::int64_t rods, int most, int threads, int family = -1) {
        return fastest_lanes(std::vector<TilingGroup>{{rods, 50, family}}, most, threads, Mapping::automatic);
    };
    for (const int most : {1, 4, 8}) {
        EXPECT_EQ(lanes(1, most, 1), 1) << most;
        for (const int rods : {2, 3, 4}) EXPECT_EQ(lanes(rods, most, 1), std::min(most, 4)) << rods;
        for (const int rods : {5, 8, 10000}) EXPECT_EQ(lanes(rods, most, 1), most) << rods;
    }
    EXPECT_EQ(lanes(2, 8, 2), 1);
    EXPECT_EQ(lanes(8, 8, 2), 4);
    EXPECT_EQ(lanes(1, 8, 1, 0), 8);
    EXPECT_EQ(lanes(1, 2, 1), 2);
    const std::vector<TilingGroup> three = {{1, 50, -1}, {1, 50, -1}, {16, 50, -1}};
    EXPECT_EQ(fastest_lanes(three, 8, 1, Mapping::automatic), 8);
}

} // namespace
} // namespace skein
