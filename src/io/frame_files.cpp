#include "io/frame_files.hpp"

#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace skein {

namespace {

constexpr double most_read_bytes = 1 << 30; ///< of a rank, when a run goes on

std::string lines_of(const std::vector<std::string>& paths) {
    std::string text;
    for (const std::string& path : paths) text += path + '\n';
    return text;
}

std::vector<std::string> paths_in(const std::string& text) {
    std::vector<std::string> paths;
    for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != text.npos; begin = end + 1)
        paths.push_back(text.substr(begin, end - begin));
    return paths;
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

std::vector<std::string> missing_frames(const std::string& kind, const std::string& directory,
                                        std::span<const FramePlace> frames, std::optional<std::int64_t> expected) {
    std::vector<std::string> found;
    std::int64_t before = -1;
    const auto gap = [&](std::int64_t to) {
        found.push_back(fmt::format("{}: the frames after step {} and up to step {} are missing from {}", kind, before,
                                    to, directory));
    };
    for (const FramePlace& frame : frames) {
        if (frame.after && *frame.after > before) gap(*frame.after);
        before = frame.step;
    }
    if (expected && *expected > before) gap(*expected);
    return found;
}

std::vector<std::int64_t> find_damaged(const Communicator& comm, std::vector<std::string> paths,
                                       const std::function<bool(const std::string&)>& sound) {
    paths = paths_in(comm.broadcast(comm.root() ? lines_of(paths) : std::string()));
    std::vector<std::int64_t> damaged(paths.size(), 0);
    double left = most_read_bytes;
    for (std::size_t back = static_cast<std::size_t>(comm.rank()); back < paths.size() && left > 0;
         back += static_cast<std::size_t>(comm.size())) {
        const std::size_t i = paths.size() - 1 - back;
        try {
            left -= static_cast<double>(std::filesystem::file_size(paths[i]));
            damaged[i] = !sound(paths[i]);
        } catch (const IoError&) {
            damaged[i] = 1;
        } catch (const std::filesystem::filesystem_error&) {
            damaged[i] = 1;
        }
    }
    comm.sum(damaged);
    return damaged;
}

} // namespace skein
