// Incompressible viscous fluid in a box: velocity and pressure on a uniform staggered grid. It is independent of rods.
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

/// Time integration.
enum class FlowScheme {
    rk3,             ///< three stages with one pressure gradient, and one projection at the end
    rk3_projected,   ///< three stages with a projection in each
    adams_bashforth, ///< one stage from the rates of this step and the last
    crank_nicolson   ///< Adams-Bashforth convection and half implicit viscosity, which does not limit the step
};
inline constexpr std::string_view flow_scheme_names[] = {"rk3", "rk3_projected", "adams_bashforth", "crank_nicolson"};

/// True for schemes that use the rates of the last step. They have one stage.
constexpr bool keeps_rates(FlowScheme scheme) {
    return scheme == FlowScheme::adams_bashforth || scheme == FlowScheme::crank_nicolson;
}

/// Consecutive stages of a step: their parts of the step in units of 1/`unit`.
struct StageParts {
    std::array<int, 3> part;
    int count, unit;

    /// Units of the first `stages` stages.
    constexpr int until(int stages) const {
        int units = 0;
        for (int s = 0; s < stages; ++s) units += nth(part, s);
        return units;
    }
};
constexpr StageParts stage_parts(FlowScheme scheme) {
    return keeps_rates(scheme) ? StageParts{{1, 0, 0}, 1, 1} : StageParts{{8, 2, 5}, 3, 15};
}

/// Solver of Poisson's equation of a projection.
enum class PressureMethod {
    direct,   ///< transforms: FastHelmholtz
    multigrid ///< iterations: PressureSolver
};
inline constexpr std::string_view pressure_method_names[] = {"direct", "multigrid"};

/// Distribution of the columns of the direct solver over ranks.
enum class ColumnExchange {
    transposes, ///< columns change ranks and are solved whole, with the same bits on any ranks
    interfaces  ///< ranks solve their own planes and exchange numbers at interfaces
};
inline constexpr std::string_view column_exchange_names[] = {"transposes", "interfaces"};

/// Profile of the velocity at inflow faces.
enum class InflowProfile {
    uniform,
    parabolic ///< parabola between no-slip walls, whose mean is the inflow
};
inline constexpr std::string_view inflow_profile_names[] = {"uniform", "parabolic"};

struct FlowConstants {
    FluidGrid grid;
    double density = 1;             ///< kg/m^3
    double kinematic_viscosity = 0; ///< m^2/s
    Vec3d inflow{0, 0, 0};          ///< mean velocity at faces of FluidBoundary::through, m/s
    InflowProfile inflow_profile = InflowProfile::uniform;
    Vec3d acceleration{0, 0, 0}; ///< driving acceleration of the whole fluid, m/s^2
    /// Tangential velocities of the lower and upper no-slip walls across each direction, m/s.
    std::array<std::array<Vec3d, 2>, 3> wall_velocity{};
    double frequency = 0; ///< frequency of a cosine factor of acceleration and wall velocities, Hz; 0: steady
    FlowScheme scheme = FlowScheme::rk3;
    PressureMethod pressure = PressureMethod::direct;
    ColumnExchange exchange = ColumnExchange::transposes;
    double pressure_tolerance = 1e-10; ///< residual of multigrid over the right side
    int ranks_across = 0;              ///< ranks that share the rows of a slab; 0: as few as the planes allow
};

/// Inflow velocity at cell [j, k] over its mean.
double inflow_share(const FlowConstants& constants, int j, int k);
/// Largest inflow_share() of any cell.
double largest_inflow_share(const FlowConstants& constants);

/// Ranks that share the rows of a slab, of `ranks` ranks; 0: these cannot share the fluid.
int ranks_across(const FlowConstants& constants, int ranks);
/// Reason why so many ranks cannot share the fluid; empty if they can.
std::string unshared(const FlowConstants& constants, int ranks);

/// Figures of a row of cells, or of all cells.
struct FlowFigures {
    double kinetic_energy = 0; ///< J
    double enstrophy = 0;      ///< half the sum of squared vorticity, m^3/s^2
    double dissipation = 0;    ///< dissipation of kinetic energy, W
    double divergence = 0;     ///< largest divergence, 1/s
    double speed = 0;          ///< largest sum of |u|, |v| and |w| of a cell, m/s
    Vec3d momentum{0, 0, 0};   ///< kg m/s
};

/// Writes a component of a velocity at places along x that are `spacing` apart. Any thread may call it.
using VelocityRow = std::function<void(int component, const Vec3d& first, double spacing, std::span<double> row)>;

class FlowSolver {
public:
    virtual ~FlowSolver() = default;

    virtual const FlowConstants& constants() const = 0;
    virtual const Pencils& pencils() const = 0;
    /// Sets the velocity to a function of place, made free of divergence, and the pressure to that of this velocity.
    /// Collective.
    virtual void set_velocity(const VelocityRow& velocity) = 0;
    /// Sets the velocity by a function of one place.
    void set_velocity(const std::function<Vec3d(const Vec3d& place)>& velocity);
    /// Sets the forcing by bodies in each stage; null: none. It must outlive its use.
    virtual void set_forcing(StageForcing* forcing) = 0;
    /// Begins stage s of a step of dt from a time, s. Explicit schemes compute it without bodies. All stages in order
    /// make the step. Throws NumericalError on all ranks if no pressure is found. Collective.
    virtual void begin_stage(int s, double time, double dt) = 0;
    /// Ends the stage, with the changes by bodies, which have come to its end. Throws NumericalError. Collective.
    virtual void end_stage(int s, double time, double dt) = 0;
    /// Makes all stages of a step.
    void step(double time, double dt);
    /// Longest step, s, by the sum of Courant numbers, 1/1.5 of the limit by viscosity, and a fortieth of a period.
    /// Collective.
    virtual double step_limit(double courant = 1) const = 0;
    /// Largest sum of |u|, |v| and |w| of a cell of this rank at the end of the last step, m/s. It is not finite if the
    /// flow is not. Not collective.
    virtual double largest_speed() const = 0;
    /// Figures of each row of this rank, with the same bits on any ranks. Not collective.
    virtual std::vector<FlowFigures> figures() const = 0;
    /// Moves the box by cells along x. Fluid at rest enters on the side ahead. Collective.
    virtual void move_box(int cells) = 0;
    /// Makes a step of dt from a time, in as few equal parts as step_limit() allows. Returns their number. Collective.
    std::int64_t step_within(double time, double dt, double courant);

    /// Layout of this rank's fields: velocity u, v, w at the upper faces of cells, pressure over density at centres.
    virtual FieldLayout layout() const = 0;
    virtual std::span<const double> velocity(int component) const = 0;
    virtual std::span<const double> pressure() const = 0;
    /// Fields that the next step depends on: velocities, pressure and, in some schemes, rates of the last step.
    virtual std::vector<std::span<double>> state() = 0;
    /// Time of state(): the end of the last stage, s.
    virtual double time() const = 0;
    /// Updates ghosts after state() was written for a time. Collective.
    virtual void refresh(double time) = 0;
    virtual std::size_t bytes() const = 0;
};

/// FlowSolver::step_limit() for a largest sum of |u|, |v| and |w| of `speed`, m/s, or of the walls' speed.
double step_limit(const FlowConstants& constants, double speed, double courant);
/// Sum of the components of the fastest wall's velocity, m/s.
double wall_speed(const FlowConstants& constants);

/// Factor of acceleration and wall velocities at a time. theory.md (76a)
double oscillation(const FlowConstants& constants, double time);
/// Integral of oscillation() over a duration from a time on, s.
double oscillation_integral(const FlowConstants& constants, double from, double duration);

/// Figures of all rows of all ranks, with the same bits on any ranks. Collective.
FlowFigures figures_of(const Communicator& comm, const FlowSolver& flow);

} // namespace skein
