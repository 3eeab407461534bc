// Small text files: atomic writes, the time series and the lock of a directory.
#pragma once

#include "io/descriptor.hpp"
#include "parallel/communicator.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Writes <path>.tmp, flushes it to the disk and renames it. Throws IoError with path and reason, e.g. a full disk.
void write_file(const std::string& path, std::string_view content);
/// Writes the texts of all ranks one after another. Collective; throws on all ranks alike.
void write_file(const Communicator& comm, const std::string& path, std::string_view part);
/// State of the time series on the disk.
struct SeriesMark {
    std::uint64_t bytes = 0, digest = 0; ///< size of the file, and its text_digest()
    std::string row;                     ///< row that could not be written
};

/// Reads a whole file; throws IoError.
std::string read_file(const std::string& path);

/// FNV-1a of 64 bits; `digest` is that of the text before.
std::uint64_t text_digest(std::string_view text, std::uint64_t digest = 0xcbf29ce484222325ull);

/// observables.csv: step, time, then one column per observable with its unit in the header, e.g. "kinetic_energy[J]".
/// Root only. A resumed run keeps the rows up to the checkpoint's step, none for a step of -1. Later and unfinished
/// rows move to observables.lost.csv. A file that differs from the checkpoint's mark is renamed
/// observables.csv.damaged, with a warning, and a new one begins. Column names of earlier programs are updated
/// (io/series_names.hpp).
class SeriesFile {
public:
    SeriesFile(std::string path, std::vector<std::string> columns, std::int64_t resume_step,
               const SeriesMark* mark = nullptr, const std::function<void(const std::string&)>& warn = {});
    /// Appends a row with 17 significant digits, which readers see at once. Steps that the file has are skipped. A row
    /// that cannot be written goes into mark().
    void append(std::int64_t step, double time, std::span<const double> values);
    const SeriesMark& mark() const { return mark_; }
    /// Waits until all rows are on the disk, before each checkpoint.
    void flush() { file_.flush(); }
    const std::string& path() const { return path_; }

private:
    std::string path_;
    std::size_t columns_;
    SeriesMark mark_; ///< state after the last whole row
    std::int64_t last_step_;
    Descriptor file_;
};

/// Exclusive lock on an output directory for the life of the object. It is a flock on <directory>/.lock, which never
/// outlives a killed process. Throws IoError with the name of the other job if the directory is locked.
class DirectoryLock {
public:
    explicit DirectoryLock(const std::string& directory);

private:
    Descriptor file_;
};

} // namespace skein
