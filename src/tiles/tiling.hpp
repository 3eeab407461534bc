// Choice of the rods of a rank that lie across tiles and along them. Rods of different numbers of elements, or few of
// them, would leave lanes empty across.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

enum class Mapping { automatic, across, along };

/// ratio of the time of a row along to that of a row across
inline constexpr double along_row = 1.1;

/// Rods that the tiling does not distinguish.
struct TilingGroup {
    std::int64_t rods;
    int elements;
    int family; ///< family, whose groups may share tiles along; -1: across only
    bool along_only = false;
    bool whole = false; ///< along in one piece each
};

/// Tile along: rods of these groups, in order, each cut into a number of pieces.
struct AlongTile {
    struct Part {
        int group;
        int pieces;
    };
    int family, rows;
    std::vector<Part> parts;
};

struct Tiling {
    std::vector<std::int64_t> across; ///< number of rods across by group: its first ones
    std::vector<AlongTile> along;     ///< remaining rods, in order

    /// Number of tiles across of a group.
    static std::int64_t tiles(std::int64_t rods, int lanes) { return (rods + lanes - 1) / lanes; }
};

/// Tiling that keeps all threads busy with the fewest rows. It changes no bit of a result.
Tiling choose_tiling(std::span<const TilingGroup> groups, int lanes, int threads, Mapping mapping = Mapping::automatic);

/// Time of the longest thread, in element-steps of eight full lanes across.
double tiling_cost(const Tiling& tiling, std::span<const TilingGroup> groups, int lanes, int threads);

/// Time of a row of a tile over that of one lane: between those of explicit steps on Cascade Lake and of implicit ones
/// on Zen 4 (bench/measurements.md).
constexpr double tile_time(int lanes) { return lanes == 1 ? 1.0 : lanes <= 4 ? 1.12 : 1.6; }
/// Lanes, `most` or fewer, that take the least time: where rods are few, lanes of wide tiles would repeat them.
int fastest_lanes(std::span<const TilingGroup> groups, int most, int threads, Mapping mapping);

} // namespace skein
