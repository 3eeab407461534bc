#include "io/pvd.hpp"

#include "io/descriptor.hpp"
#include "io/disk.hpp"
#include "io/files.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

namespace skein {

namespace {

const std::string opening = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n",
                  closing = "</Collection>\n</VTKFile>\n";

std::string line(const PvdFile::Entry& entry) {
    return fmt::format("<DataSet timestep=\"{:.17g}\" part=\"0\" file=\"{}\"/>\n", entry.time, entry.file);
}

} // namespace

void PvdFile::restart(const std::vector<Entry>& entries) {
    text_ = opening;
    for (const Entry& entry : entries) text_ += line(entry);
    write_file(path_, text_ + closing);
}

void PvdFile::append(const Entry& entry) {
    if (text_.empty()) text_ = opening;
    const std::size_t end = text_.size();
    text_ += line(entry);
    if (!std::filesystem::exists(path_)) {
        write_file(path_, text_ + closing);
        return;
    }
    Descriptor file(path_, O_WRONLY);
    if (::lseek(file, static_cast<off_t>(end), SEEK_SET) < 0) throw_system_error(path_, "cannot be written", errno);
    file.write(line(entry) + closing);
    file.close();
}

} // namespace skein
