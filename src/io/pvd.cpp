#include "io/pvd.hpp"

#include "io/descriptor.hpp"
#include "io/files.hpp"
#include "io/own_files.hpp"
#include "skein/core/error.hpp"

#include <fmt/format.h>

#include <fcntl.h>

#include <filesystem>

namespace skein {

namespace {

const std::string pvd_opening =
    "<?xml version=\"1.0\"?>\n<!-- skein -->\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n";
const std::string closing = "</Collection>\n</VTKFile>\n";

std::string line(const PvdFile::Entry& entry) {
    return fmt::format("<DataSet timestep=\"{:.17g}\" part=\"0\" file=\"{}\"/>\n", entry.time, entry.file);
}

void write_over(const std::string& path, std::size_t at, const std::string& text) {
    Descriptor file(path, O_WRONLY);
    file.write_at(at, text);
    file.close();
}

} // namespace

PvdFile::PvdFile(std::string path, const std::vector<Entry>& entries) : path_(std::move(path)), text_(pvd_opening) {
    for (const Entry& entry : entries) text_ += line(entry);
}

void PvdFile::write() {
    if (std::filesystem::exists(path_) && !is_pvd_document(read_file(path_))) set_aside(path_, path_ + ".foreign");
    write_file(path_, text_ + closing);
    begun_ = true;
}

void PvdFile::append(const Entry& entry) {
    if (!begun_) write();
    const std::string added = line(entry);
    try {
        write_over(path_, text_.size(), added + closing);
    } catch (const IoError&) { // a full disk still has room for the list before
        write_over(path_, text_.size(), closing);
        std::filesystem::resize_file(path_, text_.size() + closing.size());
        throw;
    }
    text_ += added;
}

bool is_pvd_document(std::string_view text) { return text.starts_with(pvd_opening); }

} // namespace skein
