// The runs that tell how large the error of a scene is: its elements as they are, two times and four times as many (or
// half, as given and twice), and half its step. All have samples at the same times. Scenes may be solved in place of
// stepped; then there is no step to halve, and ends are compared. `skein converge`.
#pragma once

#include "parallel/communicator.hpp"
#include "physics/scene_spec.hpp"
#include "plan/plan.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// How runs come to their results.
enum class StudyMethod {
    steps,       ///< in time
    relaxation,  ///< by time.relax, where steps have no error
    equilibrium, ///< Newton's method; so do the others
    modes,
    path
};
inline constexpr std::string_view study_method_names[] = {"steps", "relaxation", "equilibrium", "modes", "path"};

struct StudyRun {
    std::string name; ///< "<elements>_<dt>", of its directory; "<elements>_<method>" where it is solved
    SceneSpec scene;
    std::vector<std::string> changes; ///< of the scene as given, as overrides; of a path
    long elements = 0;                ///< of the group with the most
    double dt = 0;                    ///< s; 0 where it is solved
    std::int64_t steps = 0;
    double dt_limit = 0;  ///< the longest step that it may have, s
    double predicted = 0; ///< core-seconds
};

struct Study {
    static constexpr std::size_t half_step = 3;
    std::array<StudyRun, 4> runs; ///< three numbers of elements; the run as given with half its step
    std::size_t given = 0;        ///< the run as given, of the first three
    bool at_rest = false;         ///< ends are compared, as the runs end at rest
    StudyMethod method = StudyMethod::steps;
    int time_order = 2;
    double duration = 0; ///< s
    std::vector<std::string> notes;
    /// False where steps have no error, or there are none: then the run of half the step is the given one.
    bool halves_step() const { return method == StudyMethod::steps; }
    bool solved() const { return !halves_step() && method != StudyMethod::relaxation; }
    /// Runs that there are to make.
    std::span<const StudyRun> made() const { return std::span(runs).first(halves_step() ? half_step + 1 : half_step); }
};

/// Collective. Steps of the others divide the step of the scene: they are as long, or, where that is beyond their
/// limit, a half, a third, ... of it. `coarser`: half of the elements, as given, and twice as many. Throws InputError
/// where elements cannot change.
Study make_study(const Communicator& comm, const Machine& machine, const SceneSpec& scene, bool coarser);
/// The same of a scene that is solved by this method. Throws InputError also where it cannot be.
Study make_solved_study(const SceneSpec& scene, StudyMethod method, bool coarser);

/// Collective. A scene with its groups and what files say of this rank's rods.
std::vector<RodGroup> groups_for_all(const Communicator& comm, const SceneSpec& scene);

} // namespace skein
