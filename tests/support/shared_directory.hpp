// Scratch directories that all ranks of a test see.
#pragma once

#include "io/disk.hpp"
#include "parallel/communicator.hpp"

#include <sys/mount.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace skein::test {

/// An empty directory, removed with the object. Collective.
class SharedDirectory {
public:
    explicit SharedDirectory(const Communicator& comm) : comm_(comm) {
        on_root(comm, [this] {
            std::string pattern = (std::filesystem::temp_directory_path() / "skein_test_XXXXXX").string();
            if (!::mkdtemp(pattern.data())) throw_system_error(pattern, "cannot be made", errno);
            path_ = pattern;
        });
        path_ = comm.broadcast(path_);
    }
    ~SharedDirectory() {
        comm_.barrier();
        std::error_code ignored;
        if (comm_.root()) std::filesystem::remove_all(path_, ignored);
    }
    SharedDirectory(const SharedDirectory&) = delete;
    SharedDirectory& operator=(const SharedDirectory&) = delete;

    const std::string& path() const { return path_; }
    /// Names of the files in it, sorted; the same on all ranks.
    std::vector<std::string> names() const {
        comm_.barrier();
        std::vector<std::string> found;
        for (const auto& entry : std::filesystem::directory_iterator(path_))
            found.push_back(entry.path().filename().string());
        std::sort(found.begin(), found.end());
        comm_.barrier();
        return found;
    }

private:
    Communicator comm_;
    std::string path_;
};

/// A directory on a disk of its own, where mounting is permitted.
class SmallDisk {
public:
    SmallDisk(const Communicator& comm, const std::string& size) : comm_(comm), directory_(comm) {
        std::int64_t mounted = 0;
        if (comm.root()) mounted = ::mount("tmpfs", path().c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
        mounted_ = comm.broadcast(mounted) != 0;
    }
    ~SmallDisk() {
        comm_.barrier();
        if (comm_.root() && mounted_) ::umount2(path().c_str(), MNT_DETACH);
    }
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;

    bool mounted() const { return mounted_; }
    const std::string& path() const { return directory_.path(); }
    std::vector<std::string> names() const { return directory_.names(); }

private:
    Communicator comm_;
    SharedDirectory directory_;
    bool mounted_ = false;
};

} // namespace skein::test
