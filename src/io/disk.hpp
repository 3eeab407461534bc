// Files that are either complete or absent.
#pragma once

#include "parallel/communicator.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Throws IoError "<path>: <deed> (<reason>)" with the system's reason for `error` (an errno).
[[noreturn]] void throw_system_error(const std::string& path, const std::string& deed, int error);

/// Throws IoError with both numbers if the disk of `directory` has less free space than `bytes` and a little more.
/// Writers call it first, because MPI-IO may report a full disk on one rank only, or never.
void require_space(const std::string& directory, std::uint64_t bytes);

/// Reserves disk space for a file of `bytes`, so that neither a full disk nor a limit of the process can fail its
/// writing. Some file systems cannot reserve space.
void reserve_space(const std::string& path, std::uint64_t bytes);

/// Flushes a file with a temporary name to the disk and renames it to `path`.
void publish(const std::string& temporary, const std::string& path);

/// Number of a name <prefix><number of 12 digits or more><suffix>.
std::optional<std::int64_t> number_in(std::string_view name, std::string_view prefix, std::string_view suffix);
/// Files <prefix><number of 12 digits or more><suffix> of a directory by rising number; none without the directory.
struct NumberedFile {
    std::string name;
    std::int64_t number;
};
std::vector<NumberedFile> numbered_files(const std::string& directory, const std::string& prefix,
                                         const std::string& suffix);

/// Removes a file, if there is one.
void remove_file(const std::string& path);

/// Runs `deed` on all ranks. If it throws on some, all throw IoError with the message of one.
void on_all(const Communicator& comm, const std::function<void()>& deed);
/// Runs `deed` on root. If it throws, all ranks throw IoError with its message.
void on_root(const Communicator& comm, const std::function<void()>& deed);
/// Names of root, none with a line break, on all ranks. Collective.
std::vector<std::string> broadcast_names(const Communicator& comm, const std::vector<std::string>& names);

} // namespace skein
