#include "io/frame_files.hpp"

#include "io/disk.hpp"
#include "io/own_files.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace skein {

namespace {

constexpr double most_read_bytes = 1 << 30; ///< by a rank, when a run continues

/// Flags of files that are not `sound`; each rank reads its share, last files first. Collective.
std::vector<std::int64_t> find_damaged(const Communicator& comm, std::span<const FrameFile> files,
                                       const std::function<bool(const FrameFile&)>& sound) {
    std::vector<std::int64_t> damaged(files.size(), 0);
    double left = most_read_bytes;
    for (std::size_t back = to_index(comm.rank()); back < files.size() && left > 0; back += to_index(comm.size())) {
        const std::size_t i = files.size() - 1 - back;
        try {
            left -= static_cast<double>(std::filesystem::file_size(files[i].path));
            damaged[i] = !sound(files[i]);
        } catch (const IoError&) {
            damaged[i] = 1;
        } catch (const std::filesystem::filesystem_error&) {
            damaged[i] = 1;
        }
    }
    comm.sum(damaged);
    return damaged;
}

} // namespace

std::uint64_t byte_digest(std::span<const std::byte> bytes, std::uint64_t first) {
    std::uint64_t sum = 0, weighted = 0;
    for (std::uint64_t i = 0; i < bytes.size(); ++i) {
        const auto byte = std::to_integer<std::uint64_t>(bytes[i]);
        sum += byte;
        weighted += i * byte;
    }
    return 2 * weighted + (2 * first + 1) * sum;
}

std::uint64_t place_digest(std::int64_t step, std::int64_t after) {
    return 1 + 3 * static_cast<std::uint64_t>(step) + 5 * static_cast<std::uint64_t>(after);
}

void warn_of_gaps(const std::string& kind, const std::string& directory, std::span<const FramePlace> frames,
                  std::optional<std::int64_t> expected, const Warn& warn) {
    std::int64_t before = -1;
    const auto find_gap = [&](std::optional<std::int64_t> to) {
        if (warn && to && *to > before)
            warn(fmt::format("{}: the frames after step {} and up to step {} are missing from {}", kind, before, *to,
                             directory));
    };
    for (const FramePlace& frame : frames) {
        find_gap(frame.after);
        before = frame.step;
    }
    find_gap(expected);
}

void put_aside_damaged(const std::string& path, const std::string& why, const Warn& warn) {
    const std::string now = set_aside(path, path + ".damaged");
    if (warn) warn(fmt::format("{}\n  the file is renamed to {}, and the run continues without it", why, now));
}

std::int64_t check_frames(const Communicator& comm, const FrameSeries& series, const EarlierFrames& earlier,
                          const std::function<bool(const FrameFile&)>& sound,
                          const std::function<std::optional<std::int64_t>(const FrameFile&)>& take) {
    std::vector<std::string> names;
    on_root(comm, [&] {
        for (const NumberedFile& file : numbered_files(series.folder, series.prefix, series.suffix))
            if (file.number <= earlier.resume_step) names.push_back(file.name);
    });
    std::vector<FrameFile> files;
    for (const std::string& name : broadcast_names(comm, names))
        files.push_back({std::stoll(name.substr(series.prefix.size())), name, series.folder + "/" + name});
    const std::vector<std::int64_t> damaged = find_damaged(comm, files, sound);
    on_root(comm, [&] {
        std::vector<FramePlace> places;
        for (std::size_t i = 0; i < files.size(); ++i) {
            FramePlace& place = places.emplace_back(FramePlace{files[i].step, {}});
            try {
                if (damaged[i] != 0) throw IoError(files[i].path + ": is incomplete or damaged");
                place.after = take(files[i]);
            } catch (const IoError& error) {
                put_aside_damaged(files[i].path, error.what(), earlier.warn);
            }
        }
        warn_of_gaps(series.kind, series.folder, places, earlier.expected, earlier.warn);
    });
    return files.empty() ? -1 : files.back().step;
}

} // namespace skein
