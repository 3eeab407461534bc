// Instruction levels that kernels are built for, and the choice of one that this processor runs. Packs of a level are
// as wide as its registers, so the number of lanes names the level. Bits are the same at all levels.
#pragma once

#include <array>
#include <string_view>

namespace skein {

struct Level {
    std::string_view name; ///< name as -march= has it
    int lanes;             ///< doubles in a register
};

/// Pairs of level and lanes that are built. One lane is the reference for all others. It has v3 for its fused
/// multiply-adds, each of which is a call of the C library at the baseline: 30 times the time of four lanes.
inline constexpr std::array levels = {Level{"x86-64-v3", 1}, Level{"x86-64", 2}, Level{"x86-64-v3", 4},
                                      Level{"x86-64-v4", 8}};

/// Widest level that this processor runs, at most as wide as the environment variable SKEIN_LANES allows where it is
/// set.
int widest_lanes();
/// Lanes that serve a request for `asked` lanes: as many, or as many as this processor runs. Throws InputError where
/// `asked` is not the number of a level.
int served_lanes(int asked);
/// Name of the level of 1, 2, 4 or 8 lanes.
std::string_view level_name(int lanes);

} // namespace skein
