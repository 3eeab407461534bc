// Bodies in a fluid: obstacles, whose motion is prescribed, and rods.
#pragma once

#include "immersion/direct_forcing.hpp"
#include "immersion/force_balance.hpp"
#include "immersion/immersed_rods.hpp"
#include "immersion/obstacle.hpp"
#include "immersion/sharp_forcing.hpp"

#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace skein {

class Immersion {
public:
    ~Immersion();
    /// `rods` is null without rods; `across` counts ranks that share the rows of a slab.
    Immersion(const Communicator& comm, const Threads& threads, const FluidGrid& grid, const ForcingNumbers& numbers,
              std::vector<Obstacle> obstacles, std::unique_ptr<ImmersedRods> rods = nullptr, int across = 1);

    /// Forcing of the flow by all bodies.
    StageForcing& stage_forcing();
    /// Markers of rods and obstacles.
    DirectForcing& forcing() { return forcing_; }
    const DirectForcing& forcing() const { return forcing_; }
    /// True if some body acts by markers.
    bool has_markers() const { return (rods_ && rods_->has_markers()) || sharp_.size() < obstacles_.size(); }
    ImmersedRods* rods() { return rods_.get(); }
    const std::vector<Obstacle>& obstacles() const { return obstacles_; }
    /// Sets the time by which positions of rods lag behind their rates, s.
    void set_lag(double lag) { lag_ = lag; }
    double lag() const { return lag_; }
    /// Sets the way of the box with the rods, m; the grid keeps its coordinates.
    void set_box_shift(const Vec3d& shift) { box_shift_ = shift; }

    /// Couples rods and fluid both ways.
    void set_balance(std::unique_ptr<ForceBalance> balance) { balance_ = std::move(balance); }
    ForceBalance* balance() { return balance_.get(); }
    const ForceBalance* balance() const { return balance_.get(); }
    /// Before rods begin a stage: keeps the motion of bodies with sharp surfaces.
    void note_motions();
    /// When rods have come to the end of a stage, before FlowSolver::end_stage(): puts these bodies there. Collective.
    void take_motions();
    /// Two-way coupling, before a step of the fluid, whose velocities these are. Collective.
    void begin_step(double time, const std::array<const double*, 3>& velocity);
    /// Two-way coupling, before FlowSolver::begin_stage(): puts markers to their places at the end of the stage by
    /// their present velocities.
    void expect_stage(const ForceBalance::Stage& stage) { ahead_ = stage.length; }
    /// Two-way coupling, after FlowSolver::begin_stage(): sets loads on rods.
    void begin_stage(const ForceBalance::Stage& stage);
    /// Two-way coupling, before FlowSolver::end_stage(): sets velocities of markers by the way that rods have gone.
    void find_marker_velocities(const ForceBalance::Stage& stage);
    /// Two-way coupling, after FlowSolver::end_stage(): finds the residual impulses.
    void end_stage(double density);

    /// Forces of implicit stages at markers and surfaces: HeldVectors::saved(). Collective.
    std::vector<double> saved_held() const;
    /// Continues from saved_held(). Not collective.
    void restore_held(std::span<const double> saved);
    /// body(forces) for those at markers and at surfaces.
    template <class Body> void for_held(Body&& body) const {
        body(forcing_.held());
        if (surfaces_) body(surfaces_->held());
    }

    /// Sums over ranks that the following functions show. Collective.
    void sum_loads();
    /// Finds the work of bodies on the fluid from now on.
    void measure_work();
    /// Mean since the last begin_interval(), W: of the work that bodies do, and of its part that the fluid does not
    /// gain; nothing without measure_work().
    std::optional<SurfaceWork> power(double density, double time) const;
    /// Momentum over density that an obstacle has given the fluid since the last begin_interval(), m^4/s.
    Vec3d given_by_obstacle(std::size_t obstacle) const;
    /// Mean force on an obstacle since the last begin_interval(), N, by a fluid of this density.
    Vec3d force_on_obstacle(std::size_t obstacle, double density, double time) const;
    /// Mean couple on an obstacle about its centre, N m.
    Vec3d couple_on_obstacle(std::size_t obstacle, double density, double time) const;
    /// Mean force on the rods of a group, N. It includes the force that moves the fluid within their surfaces.
    Vec3d force_on_rods(std::size_t group, double density, double time) const;
    /// The same force on a single rod or body, by its number in ImmersedRods::single(), and its couple about the first
    /// node or the centre of mass.
    struct MeanLoad {
        Vec3d force{0, 0, 0}, couple{0, 0, 0}; ///< N, N m
    };
    MeanLoad load_on_single(std::size_t single, double density, double time) const;
    void begin_interval(double time);

    /// Wall time spent at markers since the last call, s.
    double take_seconds() {
        return std::exchange(seconds_, 0) + forcing_.take_seconds() + (surfaces_ ? surfaces_->take_seconds() : 0);
    }

private:
    class AllBodies;
    void place(double time, Markers& markers) const;
    /// Null with markers.
    const GivenMomentum* given_by_sharp(std::size_t obstacle) const;
    void place_obstacles(double time, Markers& markers) const;
    /// Sets the parts of bodies whose loads the forcing sums alone: obstacles, and after them rods of single().
    void set_parts();
    /// True if some rod or body that moves freely has a sharp surface.
    bool has_sharp_bodies() const { return rods_ && rods_->sharp_bodies() > 0; }
    /// Motion of a body with a sharp surface; of a rod with the place of its first node.
    struct SharpMotion {
        BodyMotion body;
        RodMotion rod;
        std::vector<Vec3d> inner_velocity, inner_spin; ///< of the fluid within: mean rates of the last stage
    };
    /// Motions of all bodies and rods with sharp surfaces as they are now. Collective.
    std::vector<SharpMotion> present_motions() const;
    void set_motion(std::size_t sharp, const SharpMotion& begin, const SharpMotion& end);
    /// Puts rods with sharp surfaces to where they come in the stage at their present rates, and finds how they
    /// respond.
    void expect_rods(const FlowStage& stage);
    /// Part of a vector over markers that belongs to own rods; markers of obstacles come first.
    template <class Vectors> auto of_rods(Vectors& of_markers) const {
        return std::span(of_markers).last(rods_->count());
    }

    Communicator comm_;
    FluidGrid grid_;
    int rank_;
    Pencils pencils_;
    int sweeps_;
    double least_slip_; ///< m/s, see ForcingNumbers
    std::vector<Obstacle> obstacles_;
    std::vector<std::size_t> sharp_;               ///< numbers of obstacles with sharp surfaces
    std::vector<std::vector<Vec3d>> about_centre_; ///< markers of obstacles, from their centres, m
    std::int64_t obstacle_markers_ = 0;
    std::unique_ptr<ImmersedRods> rods_;
    DirectForcing forcing_;
    std::vector<SharpMotion> at_begin_;     ///< when the stage began
    std::optional<SharpForcing> surfaces_;  ///< absent without sharp surfaces; obstacles come first
    bool has_sharp_rigid_ = false;          ///< some of them are of free rigid bodies
    std::unique_ptr<StageForcing> all_;     ///< markers and surfaces; null without sharp surfaces
    std::unique_ptr<ForceBalance> balance_; ///< null without two-way coupling
    double from_ = 0, lag_ = 0, ahead_ = 0; ///< s
    Vec3d box_shift_{0, 0, 0};              ///< m
    double seconds_ = 0;                    ///< wall time since take_seconds(), without forcing_
};

} // namespace skein
