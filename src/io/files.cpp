#include "io/files.hpp"

#include "io/descriptor.hpp"
#include "io/disk.hpp"
#include "io/own_files.hpp"
#include "io/series_names.hpp"
#include "skein/core/error.hpp"

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
#include <numeric>
#include <utility>

namespace skein {

namespace {

std::string directory_of(const std::string& path) {
    const auto parent = std::filesystem::path(path).parent_path().string();
    return parent.empty() ? "." : parent;
}

/// Temporary name that no other file has.
std::string free_temporary(const std::string& path) {
    std::string temporary = path + ".tmp";
    for (int n = 2; std::filesystem::is_regular_file(temporary) && std::filesystem::file_size(temporary) > 0; ++n)
        temporary = fmt::format("{}.tmp.{}", path, n);
    return temporary;
}

} // namespace

void write_file(const std::string& path, std::string_view content) {
    const std::string temporary = free_temporary(path);
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

void write_file(const Communicator& comm, const std::string& path, std::string_view part) {
    const std::vector<std::int64_t> sizes = comm.all_gather(static_cast<std::int64_t>(part.size()));
    const auto mine = sizes.begin() + comm.rank();
    const auto before = static_cast<std::uint64_t>(std::accumulate(sizes.begin(), mine, std::int64_t{0}));
    const auto all = static_cast<std::uint64_t>(std::accumulate(sizes.begin(), sizes.end(), std::int64_t{0}));
    const std::string temporary = comm.broadcast(comm.root() ? free_temporary(path) : std::string());
    try {
        on_root(comm, [&] {
            require_space(directory_of(path), all);
            Descriptor(temporary, O_WRONLY | O_CREAT | O_TRUNC).close();
        });
        on_all(comm, [&] {
            Descriptor file(temporary, O_WRONLY);
            file.write_at(before, part);
            file.flush();
            file.close();
        });
        on_root(comm, [&] { publish(temporary, path); });
    } catch (const IoError&) {
        if (comm.root()) ::unlink(temporary.c_str());
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

/// Header and whole rows up to a step. A killed run may have left an unfinished row.
std::string_view rows_up_to(std::int64_t last_step, std::string_view content, std::string_view head) {
    const auto commas = std::count(head.begin(), head.end(), ',');
    std::size_t kept = head.size();
    for (auto end = content.find('\n', kept); end != content.npos; end = content.find('\n', kept)) {
        const auto row = content.substr(kept, end + 1 - kept);
        std::int64_t step = 0;
        const auto number = std::from_chars(row.data(), row.data() + row.size(), step);
        if (number.ec != std::errc() || std::count(row.begin(), row.end(), ',') != commas || step > last_step) break;
        kept = end + 1;
    }
    return content.substr(0, kept);
}

/// Replaces the header `from` by `to`, if the content has it.
std::string with_header(std::string_view content, std::string_view from, std::string_view to) {
    if (!content.starts_with(from)) return std::string(content);
    return std::string(to).append(content.substr(from.size()));
}

/// Adds rows to the file of lost rows.
void keep_lost(const std::string& path, const std::string& head, std::string_view rows) {
    if (rows.empty()) return;
    const std::string lost = std::filesystem::path(path).replace_extension(".lost.csv").string();
    if (std::filesystem::exists(lost)) {
        const std::string before = read_file(lost), now = with_header(before, earlier_header(head), head);
        if (!now.starts_with(head)) set_aside(lost, lost + ".foreign");
        else if (now != before) write_file(lost, now);
    }
    Descriptor file(lost, O_WRONLY | O_CREAT | O_APPEND);
    if (!std::filesystem::file_size(lost)) file.write(head);
    file.write(rows);
    if (rows.back() != '\n') file.write("\n");
    file.flush();
}

/// Reason why a file does not continue `mark`, its state at a checkpoint; empty if it does.
std::string damage_of(std::string_view content, const SeriesMark& mark) {
    if (content.size() < mark.bytes) return fmt::format("it has {} bytes of {}", content.size(), mark.bytes);
    if (text_digest(content.substr(0, mark.bytes)) != mark.digest) return "its rows were changed";
    return {};
}

/// Header, with present names of columns, and rows that a resumed run keeps. Rows that it will write again move to the
/// lost ones.
std::string kept_rows(const std::string& path, const std::string& head, std::int64_t resume_step,
                      const SeriesMark* mark, const std::function<void(const std::string&)>& warn) {
    const bool there = std::filesystem::exists(path);
    const std::string earlier = earlier_header(head);
    std::string old = there ? read_file(path) : std::string();
    if (mark) {
        // A run that was killed between the update of the header and the next checkpoint has a mark with the earlier
        // header.
        if (std::string marked = with_header(old, head, earlier);
            !damage_of(old, *mark).empty() && damage_of(marked, *mark).empty())
            old = std::move(marked);
        const std::string damage = there ? damage_of(old, *mark) : "it is missing";
        if (!damage.empty()) {
            const std::string now = there ? "; it is renamed to " + set_aside(path, path + ".damaged") : "";
            if (warn)
                warn(fmt::format("{}: does not match the checkpoint of step {}: {}{}; a new time series begins", path,
                                 resume_step, damage, now));
            return head;
        }
    }
    if (!there) return head;
    const std::string& own = old.starts_with(head) ? head : earlier; // header of the file
    if (!old.starts_with(own)) {
        if (resume_step >= 0) throw IoError(path + ": its columns are not those of this run; move it away");
        set_aside(path, path + ".foreign");
        return head;
    }
    const std::string_view kept =
        mark ? std::string_view(old).substr(0, mark->bytes) : rows_up_to(resume_step, old, own);
    keep_lost(path, head, std::string_view(old).substr(kept.size()));
    return with_header(kept, own, head);
}

/// Step of the last row; -1: none.
std::int64_t last_step_in(const std::string& content, const std::string& head) {
    std::int64_t step = -1;
    if (content.size() > head.size()) {
        const auto row = content.rfind('\n', content.size() - 2) + 1;
        std::from_chars(content.data() + row, content.data() + content.size(), step);
    }
    return step;
}

/// Writes the header and the rows that a run keeps.
SeriesMark begin_series(const std::string& path, const std::string& head, std::int64_t resume_step,
                        const SeriesMark* mark, const std::function<void(const std::string&)>& warn) {
    std::string content = kept_rows(path, head, resume_step, mark, warn);
    if (mark) content += mark->row;
    write_file(path, content);
    return {content.size(), text_digest(content), {}};
}

constexpr std::string_view lock_begin = "process ";

} // namespace

std::uint64_t text_digest(std::string_view text, std::uint64_t digest) {
    for (const char c : text) digest = (digest ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
    return digest;
}

SeriesFile::SeriesFile(std::string path, std::vector<std::string> columns, std::int64_t resume_step,
                       const SeriesMark* mark, const std::function<void(const std::string&)>& warn)
    : path_(std::move(path)), columns_(columns.size()),
      mark_(begin_series(path_, header(columns), resume_step, mark, warn)),
      last_step_(last_step_in(read_file(path_), header(columns))), file_(path_, O_WRONLY | O_APPEND) {}

void SeriesFile::append(std::int64_t step, double time, std::span<const double> values) {
    if (values.size() != columns_) throw Error(Exit::internal, path_ + ": a row does not match the header");
    if (step <= last_step_) return;
    std::string row = fmt::format("{},{:.17g}", step, time);
    for (const double value : values) fmt::format_to(std::back_inserter(row), ",{:.17g}", value);
    row += '\n';
    mark_.row = row;
    file_.write(row);
    mark_ = {mark_.bytes + row.size(), text_digest(row, mark_.digest), {}};
    last_step_ = step;
}

DirectoryLock::DirectoryLock(const std::string& directory) : file_(directory + "/.lock", O_RDWR | O_CREAT) {
    const std::string path = directory + "/.lock";
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        const std::string owner = read_file(path);
        throw IoError(directory + ": in use by another run" + (owner.empty() ? "" : " (" + owner + ")"));
    }
    // A free lock in a run's own directory is valid whatever a crash left in it, so that jobs resume unattended.
    const bool own = std::filesystem::is_regular_file(directory + "/physics.json") ||
                     !numbered_files(directory, "checkpoint_", ".h5").empty();
    if (const std::string content = own ? "" : read_file(path); !content.empty() && !content.starts_with(lock_begin))
        throw IoError(path + ": is not the lock of a run; move it away, or use another --out");
    // Some file systems have no locks. The run continues without one, since a warning at every start helps nobody.
    char host[256] = "";
    ::gethostname(host, sizeof host - 1);
    if (::ftruncate(file_, 0) != 0) throw_system_error(path, "cannot be written", errno);
    file_.write(fmt::format("{}{} on {}", lock_begin, ::getpid(), host));
}

} // namespace skein
