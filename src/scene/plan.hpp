// The plan: what a run of a scene will do, worked out before anything is allocated. A pure function of the scene and of
// where it runs; printed before each run and by `skein plan`, and held by snapshot tests.
#pragma once

#include "contact/contact_spec.hpp"
#include "contact/wall.hpp"
#include "io/keeping.hpp"
#include "joints/joint_list.hpp"
#include "mechanics/kick.hpp"
#include "mechanics/step_watch.hpp"
#include "physics/contact/contact_estimate.hpp"
#include "physics/contact/speed_estimate.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "physics/scene_spec.hpp"
#include "relaxation/relaxation_estimate.hpp"
#include "rod/time_limits.hpp"
#include "scene/program.hpp"
#include "tiles/tiling.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
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
};

struct GroupPlan {
    std::string name;
    std::int64_t rods = 0;
    int elements = 0;
    std::int64_t tiles = 0; ///< across, at least; ranks may each leave one tile part full
    std::int64_t along = 0; ///< rods that lie along, on all ranks
    std::string pieces;     ///< how these are cut
    int family = -1;        ///< groups with the same passes, which may share tiles along; -1: across only
    bool heterogeneous =
        false; ///< rods have lengths, radii or shapes of their own: they lie along, each with its constants
    std::vector<std::size_t> load_numbers; ///< of `loads` in the scene
    bool walls = false;                    ///< it may touch some
    KickKind kick = KickKind::undamped;
    std::shared_ptr<const InertiaInFluid> inertia_in_fluid; ///< of rods that feel a fluid
    RelaxationContacts relaxation;                          ///< where it relaxes: what contacts may do to it
    bool undamped = true;                                   ///< nothing takes energy from its modes: a shorter step
    DampingScheme damping_scheme = DampingScheme::exponential;
    std::vector<Damping> damping;   ///< that act on this group
    std::vector<Load> loads;        ///< that act on this group, in scene order
    GroupProgram program;           ///< passes of a step, in the order they run over a tile
    double ns_per_element_step = 0; ///< predicted, where all lanes of a tile carry a rod
    std::vector<TimeLimit> limits;  ///< smallest first
    double tension_limit = 0;
    double least_rotary_scale = 1, largest_rotary_scale = 1; ///< j of the elements
    double packed_fill = 0, packed_top = 0; ///< of packed rods: share of the region's volume; its upper end, m
    double bending_shift = 0;               ///< what j does to the lowest bending frequency, relative, estimated
    std::vector<std::string> hints;         ///< where numbers cost time or accuracy for nothing (numerics.md)
    std::string start, end;
    std::string body;  ///< of bodies: mass, inertia and parts
    int assembly = -1; ///< of Plan::assemblies; -1: none

    /// Least inertia that kicks feel, over the rod's.
    double effective_inertia() const { return inertia_in_fluid ? inertia_in_fluid->least_effective() : 1; }
};

/// Rods that are joined, or copied together.
struct AssemblyPlan {
    std::string name;
    std::int64_t copies = 1, rods = 0, elements = 0; ///< the last two of a copy
    std::vector<Joint> joints;                       ///< of a copy
    std::vector<std::size_t> joints_of_table;        ///< how many of each [[joint]]
};

/// Whole steps between two events of a kind; 0: never.
struct Cadence {
    std::int64_t trajectory = 0, tips = 0, series = 0, contacts = 0, checkpoint = 0;
    double checkpoint_wall = 0; ///< s of wall time; 0: none by it
    double frames_wall = 0;     ///< s of wall time; 0: with checkpoints
};

/// Largest copy of a rank's state that is kept in memory, unless a run says otherwise, bytes.
inline constexpr double most_copied_bytes = 1 << 30;

struct Plan {
    std::string title;
    Machine machine;
    std::vector<GroupPlan> groups;
    std::int64_t rods = 0, elements = 0;
    double dt = 0, limit = 0;
    bool automatic_dt = false;
    std::string divides; ///< interval that an automatic step divides, and what it belongs to; empty: the step is given
    double rest_speed = 0;      ///< m/s, at which the run ends; 0: none
    bool relax = false;         ///< rest is wanted: the run ends when rods have settled
    double relax_tolerance = 0; ///< correction at which they have
    bool force_dt = false;      ///< a step beyond a limit does not stop the run
    Integrator integrator = Integrator::verlet;
    std::size_t governing = 0; ///< group whose limit is smallest
    std::int64_t steps = 0;
    Cadence cadence;
    Keeping keeping; ///< of checkpoints
    std::vector<InteractionSpec> interactions;
    std::vector<AssemblyPlan> assemblies;
    std::vector<JointSpec> joints;           ///< the scene's
    std::optional<ContactSpec> contact;      ///< of rods with each other; absent: nothing is searched, kept or sent
    std::optional<ContactLaws> contact_laws; ///< by pair of groups
    bool automatic_stiffness = false;        ///< of `contact`: found from what presses
    ContactEstimate estimate;                ///< of contacts and walls, where there are any
    SpeedEstimate speeds;                    ///< of what may meet, where there are any
    std::optional<FluidPlan> fluid;
    /// Steps between times at which all of a scene stands: those of the fluid where rods are in it.
    std::int64_t events_every() const { return fluid && fluid->every > 0 ? fluid->every : 1; }
    std::vector<Wall> walls;              ///< planes, tubes and balls: boxes are taken apart
    double mass = 0;                      ///< of all rods, kg
    double mass_radius = 0;               ///< sum of masses times radii, kg m
    std::optional<Vec3d> gravity;         ///< that of rods which touch something, where it is one for all; m/s^2
    bool audit = false;                   ///< energy audit
    std::vector<std::string> observables; ///< sets that the scene adds to the series
    int families = 0;
    double state_bytes = 0;          ///< all ranks, state and scratch
    bool vtp = false;                ///< frames as poly data too
    double frame_bytes = 0;          ///< all ranks, frames on their way to disk
    double copy_bytes = 0;           ///< all ranks, of the copy to go back to after a failure; 0: too large to be kept
    double output_bytes = 0;         ///< all frames of the run, but blocks of a fluid
    double most_block_bytes = 0;     ///< the most that these may take
    double predicted_s = 0;          ///< wall time of the steps
    std::vector<std::string> notes;  ///< what looks like a slip, or comes otherwise than asked for
    std::vector<std::string> absent; ///< physics and services that this scene does not need
};

/// Throws InputError where the step is beyond the limit (naming group, element and mode) unless the scene forces it.
Plan make_plan(const SceneSpec& scene, std::span<const RodGroup> groups, const Machine& machine);

bool has_rods_of_files(std::span<const RodGroup> groups);
/// Fault in the values of loads at the start of rods of files that this rank holds, which plans do not
/// look at; empty: nothing.
std::string fault_of_read_rods(const SceneSpec& scene, const Plan& plan, std::span<const RodGroup> groups);

StepWatch step_watch(const Plan& plan);

/// Rods of a rank, counted by group, that lie across, and those that lie along.
Tiling tiling_of(const Plan& plan, std::span<const std::int64_t> counts, int lanes);

/// Rods must wait for each other in every step: they touch, or a wall reacts to their forces.
bool is_coupled(const Plan& plan);

std::string to_text(const Plan& plan);
std::string to_json(const Plan& plan);

} // namespace skein
