// Frames in files of their own: a run that continues looks for damaged and missing ones.
#pragma once

#include "parallel/communicator.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Sum of (2 i + 1) b_i over bytes b_i, modulo 2^64, from index `first` on. Every change of one byte changes it, and
/// sums of parts add up.
std::uint64_t byte_digest(std::span<const std::byte> bytes, std::uint64_t first);
/// Part of a digest that identifies the frame and the one before it.
std::uint64_t place_digest(std::int64_t step, std::int64_t after);

/// Frame with the step of the one before it: -1 if it is the first, absent if unknown.
struct FramePlace {
    std::int64_t step;
    std::optional<std::int64_t> after;
};
using Warn = std::function<void(const std::string&)>;
/// Warns of frames of `kind` that are missing before others, or at the end if `expected` is the last one. `frames` is
/// in rising order of steps.
void warn_of_gaps(const std::string& kind, const std::string& directory, std::span<const FramePlace> frames,
                  std::optional<std::int64_t> expected, const Warn& warn);

/// Renames a damaged file to *.damaged and warns.
void put_aside_damaged(const std::string& path, const std::string& why, const Warn& warn);

/// Frames that a resumed run continues from.
struct EarlierFrames {
    std::int64_t resume_step = -1;             ///< earlier frames are kept up to this step; -1: none
    std::optional<std::int64_t> expected = {}; ///< step of the last frame that should exist, if known
    Warn warn = {};                            ///< called on root
};
struct FrameSeries {
    std::string kind;                   ///< name for warnings
    std::string folder, prefix, suffix; ///< files are <folder>/<prefix><step><suffix>
};
struct FrameFile {
    std::int64_t step;
    std::string name, path;
};
/// Checks earlier frames. `sound` may run on any rank and throw IoError. Files beyond 1 GiB a rank, counted from the
/// last one back, are not checked. `take` returns the step before a sound frame on root, or throws IoError. Damaged
/// frames are put aside, and `earlier.warn` hears of them and of gaps. Returns the last step with a file, or -1, on
/// root. Collective.
std::int64_t check_frames(const Communicator& comm, const FrameSeries& series, const EarlierFrames& earlier,
                          const std::function<bool(const FrameFile&)>& sound,
                          const std::function<std::optional<std::int64_t>(const FrameFile&)>& take);

} // namespace skein
