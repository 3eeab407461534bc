// Open file of the operating system, closed with its scope.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace skein {

class Descriptor {
public:
    /// Opens a file with the flags of open(2). Throws IoError.
    Descriptor(const std::string& path, int flags);
    ~Descriptor();
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    operator int() const { return value_; }
    /// Appends, or writes at the position of the file.
    void write(std::string_view text);
    /// Writes from byte `at` on.
    void write_at(std::uint64_t at, std::string_view text);
    /// Waits until all data is on the disk.
    void flush();
    /// Writers need it: a network file system may report a failed write only at the end.
    void close();

private:
    /// write(text) returns the number of bytes that it has written.
    template <class Write> void write_all(std::string_view text, Write&& write);

    std::string path_;
    int value_;
};

} // namespace skein
