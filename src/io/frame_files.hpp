// Frames that are files of their own, in a directory that a run goes on in: which are damaged, and which are missing.
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

/// Sum of (2 i + 1) b_i over bytes, modulo 2^64: the first one has the index `first`. Any change of a single byte
/// changes it, and parts add up.
std::uint64_t byte_digest(std::span<const std::byte> bytes, std::uint64_t first);
/// The part of a digest that says which frame it is, and which one came before.
std::uint64_t place_digest(std::int64_t step, std::int64_t after);

/// Where a frame stands in its series.
struct FramePlace {
    std::int64_t step;
    std::optional<std::int64_t> after; ///< step of the one before, -1 of none; absent where that is not known
};
/// Says which frames of `kind` are missing before others, or at the end, where `expected` is the last one. `frames`: by
/// rising step.
std::vector<std::string> missing_frames(const std::string& kind, const std::string& directory,
                                        std::span<const FramePlace> frames, std::optional<std::int64_t> expected);

/// Flags, not 0 of files that are not `sound`; each rank reads its share of `paths` (root's, by rising step). Files
/// that hold more than 1 GiB a rank together with later ones are not read. `sound` may throw IoError, which means no.
/// Collective.
std::vector<std::int64_t> find_damaged(const Communicator& comm, std::vector<std::string> paths,
                                       const std::function<bool(const std::string&)>& sound);

} // namespace skein
