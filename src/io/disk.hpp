// Files that are either whole or absent.
#pragma once

#include "parallel/communicator.hpp"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace skein {

/// Throws IoError "<path>: <deed> (<reason>)" with the system's reason for `error`, an errno.
[[noreturn]] void throw_system_error(const std::string& path, const std::string& deed, int error);

/// Throws IoError with both numbers where the disk of `directory` has fewer than `bytes` (and a little more) free.
/// Asked for before writing, because MPI-IO may report a full disk on some rank only, or not at all.
void require_space(const std::string& directory, std::uint64_t bytes);

/// Takes disk space for a file of `bytes`, so that writing it cannot fail for want of it, nor for a limit of the
/// process. Takes none where the file system cannot do that.
void reserve_space(const std::string& path, std::uint64_t bytes);

/// Gives a file that was written under a temporary name its own one, once its bytes are on the disk.
void publish(const std::string& temporary, const std::string& path);

/// Names in `directory` (none where it does not exist) that read <prefix><number of 12 digits or more><suffix>, by
/// rising number.
struct NumberedFile {
    std::string name;
    std::int64_t number;
};
std::vector<NumberedFile> numbered_files(const std::string& directory, const std::string& prefix,
                                         const std::string& suffix);

/// Removes a file; one that is not there is no error.
void remove_file(const std::string& path);

/// Runs `deed` on all ranks. Where it throws on some, all throw IoError with the message of one.
void on_all(const Communicator& comm, const std::function<void()>& deed);
/// Runs `deed` on root. Where it throws, all ranks throw IoError with its message.
void on_root(const Communicator& comm, const std::function<void()>& deed);

} // namespace skein
