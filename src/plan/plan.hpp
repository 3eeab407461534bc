// The plan: what a run of a scene will do, worked out before anything is allocated. A pure function of the scene and of
// where it runs; printed before each run and by `skein plan`, and held by snapshot tests.
#pragma once

#include "io/keeping.hpp"
#include "loads/damping.hpp"
#include "mechanics/kick.hpp"
#include "mechanics/step_watch.hpp"
#include "plan/core_tables.hpp"
#include "plan/physics_plan.hpp"
#include "plan/program.hpp"
#include "rod/automatic_inertia.hpp"
#include "rod/time_limits.hpp"
#include "tiles/tiling.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skein {

/// Ranks, threads and lanes of a run.
struct Machine {
    int ranks = 1;
    int threads = 1;                      ///< per rank
    int cores = 1;                        ///< that a rank may use
    int lanes = 8;                        ///< SIMD width of a tile: rods side by side
    std::string which_cores;              ///< by rank where known, e.g. "0-7 | 8-15"
    Mapping mapping = Mapping::automatic; ///< of rods onto the lanes
    int cores_per_node = 0;               ///< 0: not known
    int most_lanes = 0;                   ///< from which a plan chooses `lanes`; 0: they are given
};

struct MethodCosts;

/// How rods lie that have lengths, radii or shapes of their own.
enum class OwnSizes {
    none,  ///< all rods of the group are alike
    cut,   ///< as strands, whose passes have constants by lane
    whole, ///< the same, but uncut, as some pass takes a rod from end to end
    apart  ///< a tile and a program each, as some pass has constants of one rod
};

struct GroupPlan {
    std::string name;
    std::int64_t rods = 0;
    int elements = 0;
    std::int64_t rods_of_lane = 1; ///< of a copy, one after another in a lane
    std::int64_t tiles = 0;        ///< across, at least; ranks may each leave one tile part full
    std::int64_t along = 0;        ///< rods that lie along, on all ranks
    std::string pieces;            ///< how these are cut
    int family = -1;               ///< groups with the same passes, which may share tiles along; -1: across only
    OwnSizes own_sizes = OwnSizes::none;
    KickKind kick = KickKind::undamped;
    std::optional<double> inertia; ///< least inertia that kicks feel over the rod's, where a physics changes it
    bool undamped = true;          ///< nothing takes energy from its modes: a shorter step
    DampingScheme damping_scheme = DampingScheme::exponential;
    std::vector<Damping> damping;   ///< that act on this group
    GroupProgram program;           ///< passes of a step, in the order they run over a tile
    double ns_per_element_step = 0; ///< predicted, where all lanes of a tile carry a rod
    std::vector<TimeLimit> limits;  ///< smallest first
    bool limited_by_loads = false;  ///< loads have rates or stiffness, which limit the step by the rods' masses
    double tension_limit = 0;
    double least_rotary_scale = 1, largest_rotary_scale = 1; ///< j of the elements
    double packed_fill = 0, packed_top = 0; ///< of packed rods: share of the region's volume; its upper end, m
    double bending_shift = 0;               ///< what j does to the lowest bending frequency, relative, estimated
    std::optional<AutomaticInertia> automatic_inertia; ///< where "auto" chooses j
    std::vector<std::string> hints; ///< where numbers cost time or accuracy for nothing (numerics.md)
    Deviation deviation;            ///< of rods that are resampled from points of a file
    std::string start, end;
    std::string body; ///< of bodies: mass, inertia and parts

    /// Least inertia that kicks feel, over the rod's.
    double effective_inertia() const { return inertia.value_or(1); }
    /// Puts a limit before the others where it takes more than 1 %, which is what the bounds are worth.
    void limit(std::string_view mode, double dt, int element);
};

/// A stage of a run, in words.
struct PlannedStage {
    std::string name;
    double duration = 0; ///< s; 0: none is given
    std::string until;   ///< condition; empty: none
    std::vector<std::string> changes;
};

/// Whole steps between two events of each output; 0: never.
struct Cadence {
    std::vector<std::pair<std::string, std::int64_t>> steps; ///< by name of the output
    double checkpoint_wall = 0;                              ///< s of wall time; 0: none by it
    double frames_wall = 0;                                  ///< s of wall time; 0: with checkpoints

    std::int64_t of(std::string_view output) const {
        for (const auto& [name, every] : steps)
            if (name == output) return every;
        return 0;
    }
};

/// Largest copy of a rank's state that is kept in memory, unless a run says otherwise, bytes.
inline constexpr double most_copied_bytes = 1 << 30;

struct Plan {
    std::string title;
    Machine machine;
    std::vector<GroupPlan> groups;
    std::vector<std::shared_ptr<PhysicsPlan>> physics; ///< of the scene, in the order in which it acts
    std::int64_t rods = 0, elements = 0;
    double dt = 0, limit = 0;
    bool automatic_dt = false;
    std::string divides; ///< interval that an automatic step divides, and what it belongs to; empty: the step is given
    double rest_speed = 0;    ///< m/s, at which the run ends; 0: none
    bool pseudo_time = false; ///< time counts steps of an iteration: limits of motion do not hold
    bool force_dt = false;    ///< a step beyond a limit does not stop the run
    Integrator integrator = Integrator::verlet;
    std::size_t governing = 0; ///< group whose limit is smallest
    std::int64_t steps = 0;
    double steps_at_once = 1;      ///< steps of the clock that rods make as one, at most
    std::int64_t events_every = 1; ///< steps between times at which all of a scene stands
    Cadence cadence;
    Keeping keeping;                      ///< of checkpoints
    std::vector<std::string> observables; ///< sets that the scene adds to the series
    std::vector<PlannedStage> stages;     ///< this is the plan of the first; none: the scene is the same throughout
    int families = 0;
    bool vtp = false;             ///< frames as poly data too
    double state_bytes = 0;       ///< all ranks, state and scratch
    double rod_bytes = 0;         ///< of these, the rods themselves
    double frame_bytes = 0;       ///< all ranks, frames on their way to disk
    double copy_bytes = 0;        ///< all ranks, of the copy to go back to after a failure; 0: too large to be kept
    double output_bytes = 0;      ///< all frames of the run whose size is known
    double output_bytes_most = 0; ///< the most that others may take
    double predicted_s = 0;       ///< wall time of the steps
    double predicted_most_s = 0;  ///< the same where a bed forms; 0: none is expected
    std::string predicted_by;     ///< measurement that it follows from; empty: passes and counts
    std::shared_ptr<const MethodCosts> methods; ///< of explicit and implicit steps; null: not measured
    std::vector<std::string> notes;             ///< what looks like a slip, or comes otherwise than asked for

    /// The plan of a physics by its type; null where the scene has none.
    template <class Part> const Part* find() const {
        for (const auto& one : physics)
            if (const auto* part = dynamic_cast<const Part*>(one.get())) return part;
        return nullptr;
    }
    template <class Part> bool has() const { return find<Part>() != nullptr; }
    /// Frames of an output that comes every so many steps.
    double frames(std::int64_t every) const { return every > 0 ? static_cast<double>(steps / every + 1) : 0.0; }
    /// Rods must wait for each other, at events or in every step.
    PhysicsPlan::Coupling coupling() const;
    /// Some physics acts between rods by slot.
    bool acts_between_rods() const;
};

/// Plan of a scene whose physics have made theirs. Throws InputError where the step is beyond the limit (naming group,
/// element and mode) unless the scene forces it.
Plan make_plan(const CoreTables& scene, std::vector<std::shared_ptr<PhysicsPlan>> physics,
               std::span<const RodGroup> groups, const Machine& machine);

bool has_rods_of_files(std::span<const RodGroup> groups);

StepWatch step_watch(const Plan& plan);

/// Rods of a rank, counted by group, that lie across, and those that lie along.
Tiling tiling_of(const Plan& plan, std::span<const std::int64_t> counts, int lanes);

/// `all`: every line; otherwise at most ten, and notes.
std::string to_text(const Plan& plan, bool all = true);
std::string to_json(const Plan& plan);

} // namespace skein
