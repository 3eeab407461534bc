// Outputs of a fluid beside whole frames.
#pragma once

#include "io/output_spec.hpp"
#include "skein/core/fields.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

enum class FluidOutputKind {
    slice, ///< one plane of cells
    box,   ///< a part of the grid, or all of it; means over cubes of cells
    blocks ///< cubes of cells in which a field exceeds a threshold somewhere
};
inline constexpr std::string_view fluid_output_names[] = {"slice", "box", "blocks"};

enum class Direction { x, y, z };
inline constexpr std::string_view direction_names[] = {"x", "y", "z"};

/// Quantity that is compared with the threshold of blocks.
enum class BlockCriterion {
    q,        ///< |Q|, 1/s^2
    vorticity ///< its absolute value, 1/s
};
inline constexpr std::string_view block_criterion_names[] = {"q", "vorticity"};

/// [[fluid_output]]
struct FluidOutputSpec {
    std::string name; ///< name in file names
    FluidOutputKind kind = FluidOutputKind::slice;
    double every = 0;               ///< s
    std::vector<std::string> which; ///< fields; none: all
    Precision precision = Precision::single;
    Direction across = Direction::z; ///< normal of a slice
    double at = 0;                   ///< coordinate of a slice, m
    std::optional<Vec3d> lower;      ///< corner of a box, m; absent: corner of the fluid
    std::optional<Vec3d> upper;      ///< m
    long average = 1;                ///< cells along an edge of the cubes that a box has means over
    BlockCriterion criterion = BlockCriterion::q;
    double threshold = 0; ///< threshold of blocks, 1/s^2 or 1/s
    long edge = 16;       ///< edge of a block, cells
    std::string source;   ///< file:line of the table, for messages

    static constexpr bool output_only = true;

    void fields(FieldVisitor& f);
};

} // namespace skein
