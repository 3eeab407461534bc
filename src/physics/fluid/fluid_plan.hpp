// The fluid in a plan.
#pragma once

#include "fluid/cell_samples.hpp"
#include "fluid/fluid_probe.hpp"
#include "formula/scope.hpp"
#include "immersion/immersed_kinds.hpp"
#include "immersion/immersion_spec.hpp"
#include "immersion/obstacle.hpp"
#include "io/fluid_output_spec.hpp"
#include "io/output_spec.hpp"
#include "physics/fluid/load_columns.hpp"
#include "skein/rod/rod_group.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace skein {

/// Steps of a fluid by itself from an output to the next: more are a mistake in its velocity or its viscosity.
inline constexpr double most_fluid_steps = 1e5;

/// Frames of a fluid that a run writes.
struct FluidOutput {
    std::string name; ///< empty: of whole frames, output.fields
    FluidOutputKind kind = FluidOutputKind::box;
    double interval = 0;    ///< s, asked for
    std::int64_t every = 0; ///< steps of the run
    std::vector<CellField> fields;
    Precision precision = Precision::single;
    Direction across = Direction::z; ///< of a slice
    CellBox box;                     ///< of slices and boxes
    int edge = 0;                    ///< of blocks, cells
    CellField criterion = CellField::q;
    double threshold = 0; ///< of blocks

    double bytes_per_cell() const;
    /// Bytes of a frame of a slice or a box, or of one block.
    double frame_bytes() const;
    /// Blocks of a grid: how many there may be.
    double most_blocks(const FluidGrid& grid) const;
    /// Most bytes of a frame.
    double most_bytes(const FluidGrid& grid) const;
};

/// The cells of a slice or a box: the plane that its coordinate is in; corners are moved to the nearest ones of cells,
/// and what does not fill a cube is left out.
CellBox cells_of(const FluidOutputSpec& spec, const FluidGrid& grid);

/// Speed that steps are predicted from.
struct FluidSpeed {
    double value = 0; ///< largest sum over directions, m/s; 0: not known
    std::string by;
};

/// Rods or bodies of a group as the fluid has them.
struct RodsInFluid {
    std::string name;
    bool body = false;
    bool asks_sharp = false;              ///< the scene asks for sharp surfaces in place of markers
    double sharp = 0;                     ///< share of the length of rods, or of bodies, that has them
    std::int64_t markers = 0;             ///< of a rod or body
    double least_axis = 0, most_axis = 0; ///< half axes of sections or parts, over the spacing
    double thickest = HUGE_VAL; ///< half the thickness of thickest sections, of the thinnest rod, over the spacing
    double sharp_area = 0;      ///< of sharp surfaces of all of them, over the square of the spacing
    double density_ratio = 0;   ///< over the fluid's
    std::array<bool, 3> has{};  ///< by SectionMarkers, of rods
    double least_inertia = 1;   ///< that kicks feel, over the rod's
    bool feels_fluid = false;
};

/// The fluid around everything.
struct FluidPlan {
    FlowConstants constants;
    double courant = 0;
    std::vector<std::string> velocity_formula; ///< at the start
    std::vector<Obstacle> obstacles;
    ForcingNumbers forcing;
    FormulaScope names; ///< that it may hold
    std::vector<FluidOutput> outputs;
    std::vector<FluidProbeSpec> probes = {};
    SingleLoads single_loads = {};
    bool measures_power = false; ///< of bodies at their surfaces
    FluidSpeed speed;
    double stated = 0;       ///< m/s, the largest speed of rods that the scene states; 0: none
    double largest_slip = 0; ///< over the largest speed, above which steps are shortened; 0: it does not count
    double retraction = 0;   ///< of rods, over the spacing
    RodCoupling coupling = RodCoupling::two_way;
    bool inner_inertia = true;        ///< see ImmersionSpec
    bool follows_rods = false;        ///< the box
    std::string ranks_across_at = {}; ///< file:line of that key, for messages
    std::int64_t every =
        0; ///< with rods: steps of the run between two meetings of rods and fluid, a step of the fluid or several
    std::vector<RodsInFluid> rods;                   ///< by group
    std::shared_ptr<const ImmersedKinds> kinds = {}; ///< markers and inertia of rods

    bool two_way() const { return !rods.empty() && coupling == RodCoupling::two_way; }
    bool has_bodies() const { return !obstacles.empty() || !rods.empty(); }
    /// Steps of the fluid that may go between two meetings.
    std::int64_t most_parts() const { return every / stage_parts(constants.scheme).unit; }

    /// Longest step of the fluid at the known speed, s.
    double step_limit() const { return skein::step_limit(constants, speed.value, courant); }
    /// Steps of this length have a Courant number of 0.8; as long as they can be where no speed is known, s. theory.md
    /// (88a)
    double passing() const { return speed.value > 0 ? 0.8 * constants.grid.h / speed.value : step_limit(); }

    /// Ten fields, one more of implicit schemes with bodies, and coefficients and as many to be sent on more ranks than
    /// one, twice that where ranks share rows, or what multigrid keeps, as measured.
    double bytes_per_cell(int ranks) const;
    static constexpr double multigrid_bytes_per_cell = 400;
    /// Ranks that share the rows of a slab, of so many ranks; 1 if they cannot share the fluid at all.
    int across(int ranks) const { return unshared(constants, ranks).empty() ? ranks_across(constants, ranks) : 1; }
    /// Sent by a rank: in a direct solve for the pressure, and in all of a step; and rows and planes of ghosts in a
    /// step.
    double solve_bytes(int ranks) const;
    double column_bytes(int ranks) const;
    double ghost_bytes(int ranks) const;

    /// Steps of the fluid in a run of so many steps of dt; without a known speed, as viscosity
    /// alone asks for.
    double steps(std::int64_t run_steps, double dt) const;
    /// On one core, s.
    double step_seconds() const {
        return 1e-9 * (ns_per_cell_step() * static_cast<double>(constants.grid.count()) + surface_ns());
    }
    /// Time of that at sharp surfaces that move, ns.
    double surface_ns() const;

    /// Time of one core, for predictions.
    double ns_per_cell_step() const;
};

struct PlanInput;
/// Plan of a scene that has a fluid.
FluidPlan plan_fluid(const PlanInput& input);

} // namespace skein
