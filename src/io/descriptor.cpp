#include "io/descriptor.hpp"

#include "io/disk.hpp"
#include "skein/core/index.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace skein {

Descriptor::Descriptor(const std::string& path, int flags)
    : path_(path), value_(::open(path.c_str(), flags | O_CLOEXEC, 0644)) {
    if (value_ < 0) throw_system_error(path, "cannot be opened", errno);
}

Descriptor::~Descriptor() {
    if (value_ >= 0) ::close(value_);
}

template <class Write> void Descriptor::write_all(std::string_view text, Write&& write) {
    while (!text.empty()) {
        const ssize_t written = write(text);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) throw_system_error(path_, "cannot be written", errno);
        text.remove_prefix(to_index(written));
    }
}

void Descriptor::write(std::string_view text) {
    write_all(text, [&](std::string_view rest) { return ::write(value_, rest.data(), rest.size()); });
}

void Descriptor::write_at(std::uint64_t at, std::string_view text) {
    const auto end = static_cast<off_t>(at + text.size());
    write_all(text, [&](std::string_view rest) {
        return ::pwrite(value_, rest.data(), rest.size(), end - static_cast<off_t>(rest.size()));
    });
}

void Descriptor::flush() {
    if (::fsync(value_) != 0) throw_system_error(path_, "cannot be flushed to disk", errno);
}

void Descriptor::close() {
    if (::close(std::exchange(value_, -1)) != 0) throw_system_error(path_, "cannot be closed", errno);
}

} // namespace skein
