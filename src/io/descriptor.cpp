#include "io/descriptor.hpp"

#include "io/disk.hpp"

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

void Descriptor::write(std::string_view text) {
    while (!text.empty()) {
        const auto written = ::write(value_, text.data(), text.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) throw_system_error(path_, "cannot be written", errno);
        text.remove_prefix(static_cast<std::size_t>(written));
    }
}

void Descriptor::write_at(std::uint64_t at, std::string_view text) {
    while (!text.empty()) {
        const auto written = ::pwrite(value_, text.data(), text.size(), static_cast<off_t>(at));
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) throw_system_error(path_, "cannot be written", errno);
        text.remove_prefix(static_cast<std::size_t>(written));
        at += static_cast<std::uint64_t>(written);
    }
}

void Descriptor::flush() {
    if (::fsync(value_) != 0) throw_system_error(path_, "cannot be flushed to disk", errno);
}

void Descriptor::close() {
    if (::close(std::exchange(value_, -1)) != 0) throw_system_error(path_, "cannot be closed", errno);
}

} // namespace skein
