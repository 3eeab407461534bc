// An open file of the operating system, closed with its scope.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace skein {

class Descriptor {
public:
    /// `flags` as for open(2). Throws IoError.
    Descriptor(const std::string& path, int flags);
    ~Descriptor();
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    operator int() const { return value_; }
    void write(std::string_view text);
    /// From the byte `at` on, wherever the file stands.
    void write_at(std::uint64_t at, std::string_view text);
    /// Waits until the content is on the disk.
    void flush();
    /// For writers: closing may be where a network file system reports a failed write.
    void close();

private:
    std::string path_;
    int value_;
};

} // namespace skein
