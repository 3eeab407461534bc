// Trajectory segments as files: what is in them, whether it is what was written, and what becomes of those that a run
// cannot go on from. All functions here are for one rank alone.
#pragma once

#include "io/h5_file.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

inline const std::string trajectory_format = "skein-trajectory";

/// Frames of one file, by its name in the directory.
struct Segment {
    std::string file;
    std::vector<std::int64_t> steps;
    std::vector<double> times;
    std::optional<std::int64_t> after; ///< step of the last frame before, -1 of none; absent in version 1 of the format
};

/// Throws IoError where it cannot be read, or is none.
Segment read_segment(const std::string& directory, const std::string& name);

/// Paths of the datasets that have a frame as their first dimension: those of `groups` that the file has, and the
/// frames' own.
std::vector<std::string> frame_datasets(const H5File& file, std::span<const std::string> groups);

/// Sum of (2 i + 1) w_i over words of 4 or 8 bytes, modulo 2^64: the first one has the index `first`. Any change of a
/// single word changes it.
std::uint64_t word_digest(std::span<const std::byte> bytes, std::size_t word_bytes, std::uint64_t first);
/// The part of a frame's digest that its step and time have; not 0 for zeros, which lost blocks of a file read as. To
/// it come those of its datasets.
std::uint64_t stamp_digest(std::int64_t step, double time);

/// The first of frames k, k + stride, k + 2 stride, ... whose numbers are not those that were written; their number
/// where all are. Files of version 1 have nothing to tell it by.
std::size_t first_damaged(const std::string& path, std::span<const std::string> groups, std::size_t k,
                          std::size_t stride);

/// What a killed run left half written: named lost_<name>.h5 where its first frames are good, or
/// lost_<name>.h5.unreadable. Returns what was done, empty for what is no trajectory.
std::string salvage(const std::string& directory, const std::string& temporary, std::span<const std::string> groups);

} // namespace skein
