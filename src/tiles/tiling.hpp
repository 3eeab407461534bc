// Which rods of a rank lie across tiles and which along: rods of unlike numbers of elements, or few of them, leave
// lanes empty across.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

enum class Mapping { automatic, across, along };

/// Time of a row along over one across.
inline constexpr double along_row = 1.1;

/// Rods that are alike, for this purpose.
struct TilingGroup {
    std::int64_t rods;
    int elements;
    int family; ///< groups of one family may share tiles along; -1: across only
    bool along_only = false;
};

/// A tile along: rods of these groups, in order, each cut into so many pieces.
struct AlongTile {
    struct Part {
        int group;
        int pieces;
    };
    int family, rows;
    std::vector<Part> parts;
};

struct Tiling {
    std::vector<std::int64_t> across; ///< rods of each group that lie across, its first ones
    std::vector<AlongTile> along;     ///< the others, in order

    /// Tiles across of group g.
    static std::int64_t tiles(std::int64_t rods, int lanes) { return (rods + lanes - 1) / lanes; }
};

/// What keeps all threads busy with the fewest rows. Changes no bit of a result.
Tiling choose_tiling(std::span<const TilingGroup> groups, int lanes, int threads, Mapping mapping = Mapping::automatic);

/// Time of the longest thread, in element-steps of eight full lanes across.
double tiling_cost(const Tiling& tiling, std::span<const TilingGroup> groups, int lanes, int threads);

} // namespace skein
