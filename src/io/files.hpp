// Small text files: whole-file atomic writes and the time series.
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

/// Writes to <path>.tmp, flushes to disk, renames. Throws IoError with path and reason (e.g. disk full).
void write_file(const std::string& path, std::string_view content);
/// The same of the texts of all ranks, one after another. Collective; throws on all ranks alike.
void write_file(const Communicator& comm, const std::string& path, std::string_view part);
/// The time series as it was on the disk.
struct SeriesMark {
    std::uint64_t bytes = 0, digest = 0; ///< of the file, text_digest() of it
    std::string row;                     ///< one that could not be written
};

/// Whole content; throws IoError.
std::string read_file(const std::string& path);

/// FNV-1a, 64 bits; of a text that goes on where it has reached `digest`.
std::uint64_t text_digest(std::string_view text, std::uint64_t digest = 0xcbf29ce484222325ull);

/// observables.csv: step, time, then one column per observable, with units in the header, e.g. "kinetic_energy[J]".
/// Root only. On resume the rows up to the checkpoint's step stay; later ones, and one that a killed run left
/// unfinished, are moved to observables.lost.csv; a step of -1 keeps none. Where the file is not what the checkpoint's
/// mark says it is put aside as observables.csv.damaged, `warn` is told, and a new one begins. A file with the column
/// names of an earlier program gets those of today (io/series_names.hpp).
class SeriesFile {
public:
    SeriesFile(std::string path, std::vector<std::string> columns, std::int64_t resume_step,
               const SeriesMark* mark = nullptr, const std::function<void(const std::string&)>& warn = {});
    /// 17 significant digits; others see the row at once. A step that the file already holds is left alone.
    /// Where it cannot be written the row goes into mark().
    void append(std::int64_t step, double time, std::span<const double> values);
    const SeriesMark& mark() const { return mark_; }
    /// Waits until all rows are on the disk. Called before each checkpoint.
    void flush() { file_.flush(); }
    const std::string& path() const { return path_; }

private:
    struct Start {
        SeriesMark mark;
        std::int64_t last_step;
    };
    SeriesFile(std::string path, std::size_t columns, Start start);
    static Start begin(const std::string& path, const std::string& head, std::int64_t resume_step,
                       const SeriesMark* mark, const std::function<void(const std::string&)>& warn);

    std::string path_;
    std::size_t columns_;
    std::int64_t last_step_;
    SeriesMark mark_; ///< of whole rows in the file
    Descriptor file_;
};

/// An exclusive lock on an output directory for the life of the object (flock on <directory>/.lock, so it never
/// outlives a killed process). Throws IoError naming the other job where it is taken.
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
