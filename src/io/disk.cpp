#include "io/disk.hpp"

#include "core/share_text.hpp"
#include "io/descriptor.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <system_error>

namespace fs = std::filesystem;

namespace skein {

namespace {

constexpr std::size_t number_digits = 12; ///< fewest digits in names of numbered files

/// Flushes a file or a directory.
void flush_to_disk(const std::string& path) { Descriptor(path, O_RDONLY).flush(); }

} // namespace

void throw_system_error(const std::string& path, const std::string& deed, int error) {
    throw IoError(path + ": " + deed + " (" + std::generic_category().message(error) + ")");
}

void require_space(const std::string& directory, std::uint64_t bytes) {
    struct statvfs disk;
    if (::statvfs(directory.c_str(), &disk) != 0) throw_system_error(directory, "cannot be inspected", errno);
    const std::uint64_t available = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
    const std::uint64_t needed = bytes + bytes / 20 + (64 << 10);
    if (available >= needed) return;
    const auto [wanted, there] = bytes_texts(needed, available);
    throw IoError(fmt::format("{}: disk full: {} needed, {} available", directory, wanted, there));
}

void reserve_space(const std::string& path, std::uint64_t bytes) {
    const Descriptor file(path, O_WRONLY);
    struct rlimit most;
    if (::getrlimit(RLIMIT_FSIZE, &most) == 0 && most.rlim_cur != RLIM_INFINITY && bytes > most.rlim_cur) {
        const auto [wanted, allowed] = bytes_texts(bytes, most.rlim_cur);
        throw_system_error(path, fmt::format("{} needed, but ulimit -f allows files of {}", wanted, allowed), EFBIG);
    }
    if (::fallocate(file, FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes)) == 0) return;
    if (errno == ENOSPC || errno == EDQUOT || errno == EFBIG)
        throw_system_error(path, "disk full: no room for a file of " + bytes_text(static_cast<double>(bytes)), errno);
}

void publish(const std::string& temporary, const std::string& path) {
    std::error_code ignored;
    fs::resize_file(temporary, fs::file_size(temporary), ignored); // releases space reserved beyond the end
    flush_to_disk(temporary);
    if (::rename(temporary.c_str(), path.c_str()) != 0) throw_system_error(temporary, "cannot be renamed", errno);
    const fs::path directory = fs::path(path).parent_path();
    flush_to_disk(directory.empty() ? "." : directory.string());
}

std::optional<std::int64_t> number_in(std::string_view name, std::string_view prefix, std::string_view suffix) {
    if (name.size() < prefix.size() + number_digits + suffix.size() || !name.starts_with(prefix) ||
        !name.ends_with(suffix))
        return std::nullopt;
    std::int64_t number = 0;
    const char *begin = name.data() + prefix.size(), *end = name.data() + name.size() - suffix.size();
    const bool whole = *begin != '-' && std::from_chars(begin, end, number).ptr == end;
    return whole ? std::optional(number) : std::nullopt;
}

std::vector<NumberedFile> numbered_files(const std::string& directory, const std::string& prefix,
                                         const std::string& suffix) {
    std::vector<NumberedFile> found;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(directory, error)) {
        const std::string name = entry.path().filename().string();
        if (const auto number = number_in(name, prefix, suffix)) found.push_back({name, *number});
    }
    if (error && error != std::errc::no_such_file_or_directory)
        throw_system_error(directory, "cannot be listed", error.value());
    std::sort(found.begin(), found.end(),
              [](const NumberedFile& a, const NumberedFile& b) { return a.number < b.number; });
    return found;
}

void remove_file(const std::string& path) {
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) throw_system_error(path, "cannot be removed", errno);
}

void on_all(const Communicator& comm, const std::function<void()>& deed) {
    std::string failure;
    try {
        deed();
    } catch (const std::exception& error) {
        failure = error.what();
    }
    failure = comm.first_text(failure);
    if (!failure.empty()) throw IoError(failure);
}

void on_root(const Communicator& comm, const std::function<void()>& deed) {
    on_all(comm, [&] {
        if (comm.root()) deed();
    });
}

std::vector<std::string> broadcast_names(const Communicator& comm, const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += name + '\n';
    text = comm.broadcast(text);
    std::vector<std::string> all;
    for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != text.npos; begin = end + 1)
        all.push_back(text.substr(begin, end - begin));
    return all;
}

} // namespace skein
