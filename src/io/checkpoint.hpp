// Checkpoints: the canonical state of every rod, in rod order, whatever the number of ranks. Written to a temporary
// name, read back and verified against the state digest, renamed; older ones stay as Keeping says. Collective calls;
// every return code is agreed on by all ranks.
#pragma once

#include "io/files.hpp"
#include "io/keeping.hpp"
#include "parallel/communicator.hpp"
#include "tiles/rods.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Numbers of the scene that go with its rods.
struct SavedNumbers {
    std::string name;
    std::vector<double> numbers; ///< of the scene as a whole, the same on all ranks
    std::size_t columns = 0;     ///< of rows; 0: there are none
    std::vector<double> rows;    ///< this rank's part; that of the next rank follows it. A reader gets any part
};

struct CheckpointInfo {
    std::int64_t step = 0;
    double dt = 0;
    std::uint64_t digest = 0; ///< of the whole state
    std::string scene;        ///< canonical JSON of the scene; a run resumes only where it is equal
    std::string file;         ///< path it was read from
    std::optional<double> audited_from =
        {}; ///< J, the energy that an audit began with; with it goes the energy budget of every rod. None: no audit
    std::vector<SavedNumbers> saved = {};
    std::optional<SeriesMark> series = {};                            ///< none: there was no series
    std::optional<std::int64_t> last_trajectory = {}, last_tips = {}; ///< steps of the last frames in files, -1 of none
    std::map<std::string, std::int64_t> last_frames = {}; ///< the same of frames that are files of their own, by series
    double shift = 0;                                     ///< time of step 0, s (time/clock.hpp)
    std::string settings = {}; ///< what else its scene said, JSON; empty in files of earlier programs
    std::string ancestry = {}; ///< of a branch: whose state it began with and what has changed since, JSON; else empty
    std::int64_t version = 0;  ///< of the format
    std::uint64_t beyond = 0;  ///< part of the digest that is not of rods
};

/// Writes <directory>/checkpoint_<step, 12 digits>.h5, then removes those older ones that `keeping` lets go. Throws
/// IoError on all ranks alike, leaving no temporary file and the older checkpoints untouched; also where the state does
/// not have info.digest.
void write_checkpoint(const Communicator& comm, const std::string& directory, std::span<const RodGroup> groups,
                      const Rods& rods, const CheckpointInfo& info, const Keeping& keeping = {});

/// Loads the newest valid checkpoint of the directory into `rods`; nullopt where there is none at all. A file that is
/// damaged (cannot be opened, wrong sizes, digest of a group differs) is named, with what is wrong, through `warn`
/// (called on root), and the one before it is tried; where none is left, IoError is thrown. A sound one whose scene
/// differs from `scene`, or of another version of the format, throws InputError saying what differs. `kept`: names of
/// what else to read. `rods` is changed even where this throws.
std::optional<CheckpointInfo> read_checkpoint(const Communicator& comm, const std::string& directory,
                                              std::span<const RodGroup> groups, Rods& rods, const std::string& scene,
                                              const std::function<void(const std::string&)>& warn,
                                              std::span<const std::string> kept = {});

/// Names of the directory's checkpoints, by rising step. Root's answer on all ranks.
std::vector<std::string> checkpoint_files(const Communicator& comm, const std::string& directory);

/// What a checkpoint says of itself, without the state. Throws IoError where the file cannot be read, InputError where
/// it is of another version.
CheckpointInfo read_checkpoint_info(const Communicator& comm, const std::string& path);

/// Loads one checkpoint. `accept` is asked first, and throws where it will not have it. Throws IoError where it is
/// damaged.
CheckpointInfo load_checkpoint(const Communicator& comm, const std::string& path, std::span<const RodGroup> groups,
                               Rods& rods, const std::function<void(const CheckpointInfo&)>& accept,
                               std::span<const std::string> kept = {});

} // namespace skein
