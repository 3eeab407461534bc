// Small text files: whole-file atomic writes and the time series.
#pragma once

#include "io/descriptor.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Writes to <path>.tmp, flushes to disk, renames. Throws IoError with path and reason (e.g. disk full).
void write_file(const std::string& path, std::string_view content);
/// Whole content; throws IoError.
std::string read_file(const std::string& path);

/// observables.csv: step, time, then one column per observable, with units in the header, e.g. "kinetic_energy[J]".
/// Root only. On resume rows after `resume_step`, and one that a killed run left unfinished, are dropped (through a temporary
/// file); -1 starts a new file.
class SeriesFile {
public:
    SeriesFile(std::string path, std::vector<std::string> columns, std::int64_t resume_step);
    /// 17 significant digits; others see the row at once. A step that the file already holds is left alone.
    void append(std::int64_t step, double time, std::span<const double> values);
    /// Waits until all rows are on the disk. Called before each checkpoint.
    void flush() { file_.flush(); }
    const std::string& path() const { return path_; }

private:
    std::string path_;
    std::size_t columns_;
    std::int64_t last_step_;
    Descriptor file_;
};

/// An exclusive lock on an output directory for the life of the object (flock on <directory>/.lock, so it never outlives
/// a killed process). Throws IoError naming the other job where it is taken.
class DirectoryLock {
public:
    explicit DirectoryLock(const std::string& directory);
    ~DirectoryLock();
    DirectoryLock(const DirectoryLock&) = delete;
    DirectoryLock& operator=(const DirectoryLock&) = delete;

private:
    int descriptor_ = -1;
};

} // namespace skein
