// The runs that tell how large the error of a scene is: its elements as they are, two times and four times as many (or
// half, as given and twice), and half its step. All have samples at the same times. `skein converge`.
#pragma once

#include "parallel/communicator.hpp"
#include "physics/scene_spec.hpp"
#include "plan/plan.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace skein {

struct StudyRun {
    std::string name; ///< "<elements>_<dt>", of its directory
    SceneSpec scene;
    long elements = 0; ///< of the group with the most
    double dt = 0;     ///< s
    std::int64_t steps = 0;
    double dt_limit = 0;  ///< the longest step that it may have, s
    double predicted = 0; ///< core-seconds
};

struct Study {
    static constexpr std::size_t half_step = 3;
    std::array<StudyRun, 4> runs; ///< three numbers of elements; the run as given with half its step
    std::size_t given = 0;        ///< the run as given, of the first three
    bool at_rest = false;         ///< ends are compared, as the runs end at rest
    bool relaxes = false; ///< by time.relax, where steps have no error: the run of half the step is the given one
    int time_order = 2;
    double duration = 0; ///< s
    std::vector<std::string> notes;
    /// Runs that there are to make.
    std::span<const StudyRun> made() const { return std::span(runs).first(relaxes ? half_step : half_step + 1); }
};

/// Collective. Steps of the others divide the step of the scene: they are as long, or, where that is beyond their
/// limit, a half, a third, ... of it. `coarser`: half of the elements, as given, and twice as many. Throws InputError
/// where elements cannot change.
Study make_study(const Communicator& comm, const Machine& machine, const SceneSpec& scene, bool coarser);

/// Collective. A scene with its groups and what files say of this rank's rods.
std::vector<RodGroup> groups_for_all(const Communicator& comm, const SceneSpec& scene);

} // namespace skein
