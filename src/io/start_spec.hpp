// Start of a scene: rods at rest in their start shapes, or the state of another run.
#pragma once

#include "skein/core/fields.hpp"

#include <cstdint>
#include <optional>

namespace skein {

/// Time of a run that starts from another run's state: it goes on or begins at zero.
enum class StartTime { goes_on, zero };
inline constexpr std::string_view start_time_names[] = {"goes_on", "zero"};

struct StartSpec {
    std::string from; ///< directory of a run, or "directory@step"; empty: the rods' start shapes
    StartTime time = StartTime::goes_on;

    void fields(FieldVisitor& f);
};

/// A checkpoint of another run.
struct CheckpointName {
    std::string directory;
    std::optional<std::int64_t> step; ///< none: the newest that is sound
};

/// Reads "directory" or "directory@step". Throws InputError where what follows the @ is no step.
CheckpointName checkpoint_name(const std::string& text);

} // namespace skein
