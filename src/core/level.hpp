// Levels of instructions that kernels are built for, and which of them this processor runs. Packs of a level are as
// wide as its registers, so the number of lanes names the level. Bits are the same at all of them.
#pragma once

#include <array>
#include <string_view>

namespace skein {

struct Level {
    std::string_view name; ///< as -march= has it
    int lanes;             ///< doubles in a register
};

/// Pairs of level and lanes that are built. One lane is the reference that all others are held against; it has v3 for
/// its fused multiply-adds, each of which is a call of the C library at the baseline: 30 times the time of four lanes.
inline constexpr std::array levels = {Level{"x86-64-v3", 1}, Level{"x86-64", 2}, Level{"x86-64-v3", 4},
                                      Level{"x86-64-v4", 8}};

/// Widest level that this processor runs; no wider than the environment variable SKEIN_LANES says, where it is set.
int widest_lanes();
/// Lanes that serve where `asked` are wanted: as many, or what this processor runs. Throws InputError for a number
/// that is not that of a level.
int served_lanes(int asked);
/// Of 1, 2, 4 or 8 lanes.
std::string_view level_name(int lanes);

} // namespace skein
