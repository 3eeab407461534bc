#include "io/files.hpp"

#include "core/error.hpp"
#include "io/descriptor.hpp"
#include "io/disk.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

namespace skein {

namespace {

std::string directory_of(const std::string& path) {
    const auto parent = std::filesystem::path(path).parent_path().string();
    return parent.empty() ? "." : parent;
}

} // namespace

void write_file(const std::string& path, std::string_view content) {
    const std::string temporary = path + ".tmp";
    require_space(directory_of(path), content.size());
    try {
        Descriptor file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
        file.write(content);
        file.close();
        publish(temporary, path);
    } catch (const IoError&) {
        ::unlink(temporary.c_str());
        throw;
    }
}

std::string read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw_system_error(path, "cannot be opened", errno);
    std::string content{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (file.bad()) throw_system_error(path, "cannot be read", errno);
    return content;
}

namespace {

std::string header(std::span<const std::string> columns) {
    std::string line = "step,time[s]";
    for (const auto& column : columns) line += "," + column;
    return line + "\n";
}

/// The header and the whole rows up to a step. A row that a killed run did not finish is not whole.
std::string rows_up_to(std::int64_t last_step, std::string_view content, std::string_view head) {
    const auto commas = std::count(head.begin(), head.end(), ',');
    std::string kept(head);
    content.remove_prefix(head.size());
    for (auto end = content.find('\n'); end != content.npos; end = content.find('\n')) {
        const auto row = content.substr(0, end + 1);
        std::int64_t step = 0;
        const auto number = std::from_chars(row.data(), row.data() + row.size(), step);
        if (number.ec != std::errc() || std::count(row.begin(), row.end(), ',') != commas || step > last_step) break;
        kept += row;
        content.remove_prefix(row.size());
    }
    return kept;
}

/// Makes the file hold whole rows up to a step; returns the last one's, -1 where there is none.
std::int64_t cut_back(const std::string& path, const std::string& head, std::int64_t resume_step) {
    std::string content = head;
    if (resume_step >= 0 && std::filesystem::exists(path)) {
        const std::string old = read_file(path);
        if (!old.starts_with(head)) throw IoError(path + ": its columns are not those of this run; move it away");
        content = rows_up_to(resume_step, old, head);
    }
    write_file(path, content);
    std::int64_t last_step = -1;
    if (content.size() > head.size()) {
        const auto row = content.rfind('\n', content.size() - 2) + 1;
        std::from_chars(content.data() + row, content.data() + content.size(), last_step);
    }
    return last_step;
}

} // namespace

SeriesFile::SeriesFile(std::string path, std::vector<std::string> columns, std::int64_t resume_step)
    : path_(std::move(path)), columns_(columns.size()), last_step_(cut_back(path_, header(columns), resume_step)),
      file_(path_, O_WRONLY | O_APPEND) {}

void SeriesFile::append(std::int64_t step, double time, std::span<const double> values) {
    if (values.size() != columns_) throw Error(Exit::internal, path_ + ": a row does not match the header");
    if (step <= last_step_) return;
    std::string row = fmt::format("{},{:.17g}", step, time);
    for (const double value : values) fmt::format_to(std::back_inserter(row), ",{:.17g}", value);
    row += '\n';
    file_.write(row);
    last_step_ = step;
}

DirectoryLock::DirectoryLock(const std::string& directory) {
    const std::string path = directory + "/.lock";
    descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) throw_system_error(path, "cannot be opened", errno);
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        ::close(descriptor_);
        const std::string owner = read_file(path);
        throw IoError(directory + ": in use by another run" + (owner.empty() ? "" : " (" + owner + ")"));
    }
    // Where the file system knows no locks the run goes on without: a warning at every start would help nobody.
    char host[256] = "";
    ::gethostname(host, sizeof host - 1);
    const std::string owner = fmt::format("process {} on {}", ::getpid(), host);
    if (::ftruncate(descriptor_, 0) != 0 || ::write(descriptor_, owner.data(), owner.size()) < 0) {
        const int error = errno;
        ::close(descriptor_);
        throw_system_error(path, "cannot be written", error);
    }
}

DirectoryLock::~DirectoryLock() { ::close(descriptor_); }

} // namespace skein
