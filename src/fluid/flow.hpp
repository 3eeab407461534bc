// An incompressible viscous fluid in a box: velocity and pressure on a uniform staggered grid, stepped in time. Knows
// no rods.
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/pencils.hpp"
#include "fluid/stage_forcing.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"
#include "skein/core/index.hpp"

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace skein {

/// How a step goes from one time to the next.
enum class FlowScheme {
    rk3,             ///< three stages; the pressure gradient held in them, one projection at the end
    rk3_projected,   ///< the same with a projection in every stage
    adams_bashforth, ///< one stage, from the rates of this step and the last
    crank_nicolson   ///< the same for convection; viscosity half implicit, which does not limit the step
};
inline constexpr std::string_view flow_scheme_names[] = {"rk3", "rk3_projected", "adams_bashforth", "crank_nicolson"};

/// Whether a step goes on with the rates of the last one; such schemes have one stage.
constexpr bool keeps_rates(FlowScheme scheme) {
    return scheme == FlowScheme::adams_bashforth || scheme == FlowScheme::crank_nicolson;
}

/// Stages of a step, which follow each other in time: the parts of the step that they take, in `unit` equal ones.
struct StageParts {
    std::array<int, 3> part;
    int count, unit;

    /// Units that the first `stages` of them take.
    constexpr int until(int stages) const {
        int units = 0;
        for (int s = 0; s < stages; ++s) units += nth(part, s);
        return units;
    }
};
constexpr StageParts stage_parts(FlowScheme scheme) {
    return keeps_rates(scheme) ? StageParts{{1, 0, 0}, 1, 1} : StageParts{{8, 2, 5}, 3, 15};
}

/// How Poisson's equation of a projection is solved.
enum class PressureMethod {
    direct,   ///< by transforms: FastHelmholtz
    multigrid ///< by iterations: PressureSolver
};
inline constexpr std::string_view pressure_method_names[] = {"direct", "multigrid"};

/// How ranks share the columns of the direct solver.
enum class ColumnExchange {
    transposes, ///< columns change ranks and are solved whole: the same bits on any ranks
    interfaces  ///< ranks solve their own planes, and tell each other what is at interfaces
};
inline constexpr std::string_view column_exchange_names[] = {"transposes", "interfaces"};

/// How the velocity at faces where fluid comes in depends on the place.
enum class InflowProfile {
    uniform,
    parabolic ///< between no-slip walls; the inflow is its mean
};
inline constexpr std::string_view inflow_profile_names[] = {"uniform", "parabolic"};

struct FlowConstants {
    FluidGrid grid;
    double density = 1;             ///< kg/m^3
    double kinematic_viscosity = 0; ///< m^2/s
    Vec3d inflow{0, 0, 0};          ///< velocity at faces of FluidBoundary::through, m/s
    InflowProfile inflow_profile = InflowProfile::uniform;
    Vec3d acceleration{0, 0, 0}; ///< of the whole fluid, by what drives it, m/s^2
    /// Of the lower and the upper no-slip wall across each direction, along these walls, m/s.
    std::array<std::array<Vec3d, 2>, 3> wall_velocity{};
    double frequency = 0; ///< Hz, of the cosine that acceleration and velocities of walls are multiplied by; 0: of none
    FlowScheme scheme = FlowScheme::rk3;
    PressureMethod pressure = PressureMethod::direct;
    ColumnExchange exchange = ColumnExchange::transposes;
    double pressure_tolerance = 1e-10; ///< of multigrid
    int ranks_across = 0;              ///< that share the rows of a slab of planes; 0: as few as the planes allow
};

/// Velocity where fluid comes in at cell [j, k] over its mean, and the largest.
double inflow_share(const FlowConstants& constants, int j, int k);
double largest_inflow_share(const FlowConstants& constants);

/// Of so many ranks; 0: they cannot share the fluid.
int ranks_across(const FlowConstants& constants, int ranks);
/// Why so many ranks cannot share the fluid; empty: they can.
std::string unshared(const FlowConstants& constants, int ranks);

/// Of a row of cells, or of all.
struct FlowFigures {
    double kinetic_energy = 0; ///< J
    double enstrophy = 0;      ///< half the sum of squared vorticity, m^3/s^2
    double dissipation = 0;    ///< of that kinetic energy, W
    double divergence = 0;     ///< the largest, 1/s
    double speed = 0;          ///< the largest sum of |u|, |v| and |w| of a cell, m/s
    Vec3d momentum{0, 0, 0};   ///< kg m/s
};

/// A component of a velocity at places a `spacing` apart along x. Of any thread.
using VelocityRow = std::function<void(int component, const Vec3d& first, double spacing, std::span<double> row)>;

class FlowSolver {
public:
    virtual ~FlowSolver() = default;

    virtual const FlowConstants& constants() const = 0;
    virtual const Pencils& pencils() const = 0;
    /// Sets the velocity to that of a function of place, made free of divergence, and the pressure to that which
    /// belongs to it. Collective.
    virtual void set_velocity(const VelocityRow& velocity) = 0;
    /// The same of a function of one place.
    void set_velocity(const std::function<Vec3d(const Vec3d& place)>& velocity);
    /// What changes velocities in each stage, of bodies in the fluid; null: nothing. Must outlive its use.
    virtual void set_forcing(StageForcing* forcing) = 0;
    /// Stage s of a step of dt from a time, s; all of stage_parts() in order make the step. First as if there were no
    /// bodies, of explicit schemes; then, when bodies have come to its end, what they change. Throw NumericalError on
    /// all ranks where no pressure is found. Collective.
    virtual void begin_stage(int s, double time, double dt) = 0;
    virtual void end_stage(int s, double time, double dt) = 0;
    /// All of them.
    void step(double time, double dt);
    /// The longest step, s, of a sum of Courant numbers of 1, or of 1.5 of the most that viscosity allows, and a
    /// fortieth of a period. Collective.
    virtual double step_limit(double courant = 1) const = 0;
    /// The largest sum of |u|, |v| and |w| of a cell of this rank at the end of the last step, m/s; where the flow is
    /// not finite neither is this. Not collective.
    virtual double largest_speed() const = 0;
    /// By row of this rank, the same bits on any ranks. Not collective.
    virtual std::vector<FlowFigures> figures() const = 0;
    /// The box moves so many cells along x, to the upper side where positive: fluid at rest comes in there. Collective.
    virtual void move_box(int cells) = 0;
    /// A step of dt from a time, or equal parts of it, as long as the sum of Courant numbers and viscosity allow.
    /// Returns how many. Collective.
    std::int64_t step_within(double time, double dt, double courant);

    /// Fields of this rank, as layout() has them: velocity u, v, w at the upper faces of cells, pressure over density
    /// at centres.
    virtual FieldLayout layout() const = 0;
    virtual std::span<const double> velocity(int component) const = 0;
    virtual std::span<const double> pressure() const = 0;
    /// What the next step depends on: velocities, pressure and, of schemes that need them, the rates of the last step.
    virtual std::vector<std::span<double>> state() = 0;
    /// Of what state() is of: the end of the last stage, s.
    virtual double time() const = 0;
    /// After state() was written, of a time. Collective.
    virtual void refresh(double time) = 0;
    virtual std::size_t bytes() const = 0;
};

/// The longest step, s, of a fluid whose largest sum of |u|, |v| and |w| is `speed`, m/s, or soon that of its walls;
/// see FlowSolver::step_limit.
double step_limit(const FlowConstants& constants, double speed, double courant);
/// Sum of the components of the fastest wall's velocity, m/s.
double wall_speed(const FlowConstants& constants);

/// What acceleration and velocities of walls are multiplied by at a time.                                    theory.md
/// (76a)
double oscillation(const FlowConstants& constants, double time);
/// Its integral from a time on, s.
double oscillation_integral(const FlowConstants& constants, double from, double duration);

/// Of all rows of all ranks, the same bits on any. Collective.
FlowFigures figures_of(const Communicator& comm, const FlowSolver& flow);

} // namespace skein
