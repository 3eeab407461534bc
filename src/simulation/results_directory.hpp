// The directory of a run's results, as a run finds it and before it writes there.
#pragma once

#include "io/files.hpp"

#include <string>

namespace skein {

/// Name of a result in a directory; empty where it holds none but the scene of a run that wrote nothing else, or is
/// none.
std::string result_in(const std::string& directory);

/// Lock on the directory, held by one rank alone.
class ResultsDirectory {
public:
    /// Makes and locks it. With `anew`, earlier results go to <path>/previous_1, _2, ... and the user is told; nothing
    /// is removed.
    ResultsDirectory(const std::string& path, bool anew);

    /// Without a checkpoint to resume from, refuses to write among results, or files with names of results,
    /// unless they are what a run of the same physics left unfinished. Then records the physics.
    void begin(const std::string& physics) const;

private:
    std::string path_;
    DirectoryLock lock_;
};

} // namespace skein
