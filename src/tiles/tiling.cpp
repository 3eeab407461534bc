#include "tiles/tiling.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace skein {

namespace {

// Rows of time that a tile costs besides its own.
constexpr double tile_rows = 2, along_tile_rows = 3;
// Rows of a tile that the second cache holds beside its loads, 1280 B each with eight lanes. Longer tiles take twice as
// long.
constexpr int cached_rows = 600;
double rows_cost(double rows, int lanes) { return rows * lanes > 8 * cached_rows ? 2 * rows : rows; }
constexpr int least_rows = 4; // least rows of a piece: the seam between two is computed twice

struct PooledRod {
    int group, elements;
    bool whole;
    int pieces = 1;
    int rows() const { return (elements + pieces - 1) / pieces; }
};

/// Packs rods into tiles: first fit, longest first. Rods are cut into pieces of at most `longest` rows where these keep
/// four rows at least.
std::vector<AlongTile> pack(std::vector<PooledRod> rods, int family, int longest, int lanes) {
    for (PooledRod& rod : rods)
        if (!rod.whole)
            rod.pieces = std::clamp((rod.elements + longest - 1) / longest, 1,
                                    std::min(lanes, std::max(1, rod.elements / least_rows)));
    const auto longer = [](const PooledRod& a, const PooledRod& b) { return a.rows() > b.rows(); };
    if (!std::is_sorted(rods.begin(), rods.end(), longer)) std::stable_sort(rods.begin(), rods.end(), longer);
    std::vector<AlongTile> tiles;
    std::vector<int> room;
    std::size_t open = 0; // earlier tiles are full
    for (const PooledRod& rod : rods) {
        std::size_t t = open;
        while (t < tiles.size() && room[t] < rod.pieces) ++t;
        if (t == tiles.size()) {
            tiles.push_back({family, rod.rows(), {}});
            tiles.back().parts.reserve(to_index(lanes / rod.pieces));
            room.push_back(lanes);
        }
        tiles[t].parts.push_back({rod.group, rod.pieces});
        room[t] -= rod.pieces;
        while (open < tiles.size() && room[open] == 0) ++open;
    }
    return tiles;
}

/// Pooled rods of a family, cut so that threads end together and tiles stay in cache.
std::vector<AlongTile> best_packing(const std::vector<PooledRod>& rods, int family, int lanes, int threads) {
    const double total =
        std::accumulate(rods.begin(), rods.end(), 0.0, [](double sum, const PooledRod& r) { return sum + r.elements; });
    Tiling best;
    double least = std::numeric_limits<double>::infinity();
    for (const double share : {1.0, 1.15, 1.3, 1.6, 2.0, 3.0, 4.0, 6.0, 8.0}) {
        const int longest =
            std::clamp(static_cast<int>(std::min(1e6, share * total / (lanes * threads))) + 1, least_rows, cached_rows);
        Tiling tiles{.across = {}, .along = pack(rods, family, longest, lanes)};
        const double cost = tiling_cost(tiles, {}, lanes, threads);
        if (cost < least) {
            least = cost;
            best = std::move(tiles);
        }
        if (longest == cached_rows) break;
    }
    return std::move(best.along);
}

/// Tiling with these numbers of rods across.
Tiling tiling_with(std::vector<std::int64_t> across, std::span<const TilingGroup> groups, int lanes, int threads) {
    Tiling tiling{std::move(across), {}};
    int families = 0;
    for (const TilingGroup& g : groups) families = std::max(families, g.family + 1);
    for (int family = 0; family < families; ++family) {
        std::vector<PooledRod> pool;
        for (std::size_t g = 0; g < groups.size(); ++g)
            if (groups[g].family == family)
                pool.insert(pool.end(), to_index(groups[g].rods - tiling.across[g]),
                            PooledRod{static_cast<int>(g), groups[g].elements, groups[g].whole});
        if (pool.empty()) continue;
        auto tiles = best_packing(pool, family, lanes, threads);
        tiling.along.insert(tiling.along.end(), std::make_move_iterator(tiles.begin()),
                            std::make_move_iterator(tiles.end()));
    }
    return tiling;
}

} // namespace

double tiling_cost(const Tiling& tiling, std::span<const TilingGroup> groups, int lanes, int threads) {
    double total = 0, longest = 0;
    const auto add = [&](double tiles, double cost) {
        if (tiles == 0) return;
        total += tiles * cost;
        longest = std::max(longest, cost);
    };
    for (std::size_t g = 0; g < tiling.across.size(); ++g)
        add(static_cast<double>(Tiling::tiles(tiling.across[g], lanes)),
            lanes * (rows_cost(groups[g].elements, lanes) + tile_rows));
    for (const AlongTile& t : tiling.along) add(1, lanes * (along_row * rows_cost(t.rows, lanes) + along_tile_rows));
    return std::max(total / threads, longest);
}

Tiling choose_tiling(std::span<const TilingGroup> groups, int lanes, int threads, Mapping mapping) {
    const auto with = [&](auto rods_across) {
        std::vector<std::int64_t> across;
        for (const TilingGroup& g : groups) across.push_back(g.family < 0 ? g.rods : g.along_only ? 0 : rods_across(g));
        return tiling_with(std::move(across), groups, lanes, threads);
    };
    const auto none = [](const TilingGroup&) { return std::int64_t{0}; };
    const auto full_tiles = [&](const TilingGroup& g) {
        return g.elements > cached_rows ? 0 : g.rods - g.rods % lanes;
    };
    Tiling best = with([](const TilingGroup& g) { return g.rods; });
    const bool fixed =
        std::all_of(groups.begin(), groups.end(), [](const TilingGroup& g) { return g.family < 0 || g.along_only; });
    if (mapping == Mapping::across || lanes == 1 || fixed) return best;
    if (mapping == Mapping::along) return with(none);
    double least = tiling_cost(best, groups, lanes, threads);
    const auto consider = [&](Tiling other) {
        const double cost = tiling_cost(other, groups, lanes, threads);
        if (cost < 0.97 * least) {
            least = cost;
            best = std::move(other);
        }
    };
    consider(with(full_tiles));
    // All of them lie along where tiles are fewer than threads could use.
    std::int64_t tiles = 0;
    for (const TilingGroup& g : groups) tiles += g.rods / lanes;
    if (tiles < 8L * threads) consider(with(none));
    return best;
}

int fastest_lanes(std::span<const TilingGroup> groups, int most, int threads, Mapping mapping) {
    if (most < 4) return most; // the level of two lanes has no other of its instructions
    int fastest = most;
    double least = std::numeric_limits<double>::infinity();
    for (const int lanes : {8, 4, 1}) {
        if (lanes > most) continue;
        const Tiling tiling = choose_tiling(groups, lanes, threads, mapping);
        const double cost = tiling_cost(tiling, groups, lanes, threads) / lanes * tile_time(lanes);
        if (cost < 0.95 * least) {
            least = cost;
            fastest = lanes;
        }
    }
    return fastest;
}

} // namespace skein
