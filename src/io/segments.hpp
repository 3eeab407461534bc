// Trajectory segments as files: their content, its check, and the rescue of unfinished ones. No function is collective.
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

/// Frames of one file.
struct Segment {
    std::string file; ///< name in the directory
    std::vector<std::int64_t> steps;
    std::vector<double> times;
    std::optional<std::int64_t> after; ///< step of the frame before, -1: none; absent in version 1 of the format
};

/// Throws IoError if the file is unreadable or no segment.
Segment read_segment(const std::string& directory, const std::string& name);

/// Paths of the datasets whose first dimension is the frame: those of `groups`, and /step, /time and /digest.
std::vector<std::string> frame_datasets(const H5File& file, std::span<const std::string> groups);

/// Sum of (2 i + 1) w_i over words w_i of 4 or 8 bytes, modulo 2^64, from index `first` on. Every change of one word
/// changes it.
std::uint64_t word_digest(std::span<const std::byte> bytes, std::size_t word_bytes, std::uint64_t first);
/// Digest of a dataset [rows, ...], or of frame k of a dataset [frames, rows, ...].
std::uint64_t dataset_digest(const H5File& file, const std::string& path, std::optional<std::uint64_t> k = {});
/// Part of a frame's digest for its step and time. It is not 0 for zeros, as which lost blocks of a file read.
std::uint64_t stamp_digest(std::int64_t step, double time);

/// First of the frames k, k + stride, k + 2 stride, ... with a wrong digest, or the number of frames. Files of version
/// 1 have no digests.
std::size_t first_damaged(const std::string& path, std::span<const std::string> groups, std::size_t k,
                          std::size_t stride);

/// Renames an unfinished segment of a killed run to lost_<name>.h5 if its first frames are good, else to
/// lost_<name>.h5.unreadable. Returns a report, empty if the file is no trajectory.
std::string salvage(const std::string& directory, const std::string& temporary, std::span<const std::string> groups);

} // namespace skein
