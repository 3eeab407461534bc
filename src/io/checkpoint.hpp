// Checkpoints: the canonical state of every rod in rod order, on any number of ranks. A checkpoint is written under a
// temporary name, read back, verified against the digest of the state, and renamed. Keeping decides on older ones. All
// calls are collective, and ranks agree on every outcome.
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

/// Numbers beside the state of rods, e.g. of an interaction.
struct SavedNumbers {
    std::string name;
    std::vector<double> numbers; ///< equal on all ranks
    std::size_t columns = 0;     ///< columns of `rows`; 0: no rows
    std::vector<double> rows;    ///< this rank's part, in the order of ranks; a reader gets any part
};

struct CheckpointInfo {
    std::int64_t step = 0;
    double dt = 0;
    std::uint64_t digest = 0; ///< digest of the whole state
    std::string scene;        ///< canonical JSON of the scene; a run resumes only with the same
    std::string file;         ///< path of the checkpoint
    /// Energy at the start of an audit, J. Energy budgets of rods are saved with it. Absent without an audit.
    std::optional<double> audited_from = {};
    std::vector<SavedNumbers> saved = {};
    std::optional<SeriesMark> series = {};                            ///< absent without a time series
    std::optional<std::int64_t> last_trajectory = {}, last_tips = {}; ///< steps of the last frames, -1: none
    std::map<std::string, std::int64_t> last_frames = {};             ///< by series with a file a frame: its last step
    double shift = 0;                                                 ///< time of step 0, s (time/clock.hpp)
    std::string settings = {};             ///< further settings of the scene, JSON; empty in files of earlier programs
    std::string ancestry = {};             ///< JSON of a branch: its origin and changed keys; else empty
    std::vector<double> stage_begins = {}; ///< times at which stages so far have begun, s; empty without stages
    bool stage_over = false;               ///< the last of them ends with this step
    double stage_defect = 0, stage_contacts = 0; ///< as it ends: defect of the balance and energy of contacts, J
    double stage_work = 0;                       ///< energy that changes of stages have brought, J
    std::int64_t version = 0;                    ///< version of the format
    std::uint64_t beyond = 0;                    ///< part of the digest that does not belong to rods
};

/// Writes <directory>/checkpoint_<step, 12 digits>.h5, then removes older ones by `keeping`. Throws IoError on all
/// ranks alike, also if the digest of the state is not info.digest. A failure leaves older checkpoints and no temporary
/// file.
void write_checkpoint(const Communicator& comm, const std::string& directory, std::span<const RodGroup> groups,
                      const Rods& rods, const CheckpointInfo& info, const Keeping& keeping = {});

/// Thrown where a checkpoint is of another stage than the rods that it is to be loaded into.
struct OtherStage {
    std::vector<double> begins; ///< CheckpointInfo::stage_begins
    std::string file;           ///< of the checkpoint; newer ones are damaged
};

/// Loads the newest valid checkpoint of the directory into `rods`; nullopt without a checkpoint. Damaged files
/// (unreadable, wrong sizes, wrong digests) are reported by `warn` on root, and the next older one is tried. Throws
/// IoError if none is left. A sound one with another `scene` or version of the format throws InputError with the
/// differences. `accept` runs before a state is read. Files newer than `newest`, a path, are left out. `saved` names
/// further numbers to read. `rods` changes even if this throws.
std::optional<CheckpointInfo> read_checkpoint(const Communicator& comm, const std::string& directory,
                                              std::span<const RodGroup> groups, Rods& rods, const std::string& scene,
                                              const std::function<void(const std::string&)>& warn,
                                              std::span<const std::string> saved = {},
                                              const std::function<void(const CheckpointInfo&)>& accept = {},
                                              const std::string& newest = {});

/// Names of the checkpoints that root finds in the directory, by rising step.
std::vector<std::string> checkpoint_files(const Communicator& comm, const std::string& directory);

/// Reads a checkpoint without the state. Throws IoError if it is unreadable, InputError for another version.
CheckpointInfo read_checkpoint_info(const Communicator& comm, const std::string& path);

/// Loads one checkpoint. `accept` runs before the state is read, and throws to refuse it. `may_begin_memory`: of a
/// branch, whose joints and walls may begin with no memory. Throws IoError on damage.
CheckpointInfo load_checkpoint(const Communicator& comm, const std::string& path, std::span<const RodGroup> groups,
                               Rods& rods, const std::function<void(const CheckpointInfo&)>& accept,
                               std::span<const std::string> saved = {}, bool may_begin_memory = false);

} // namespace skein
