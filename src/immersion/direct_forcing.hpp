// Direct forcing: each stage sets velocities of the fluid near markers to the markers' velocities, in a few sweeps.
// Under implicit viscosity forces at markers persist from step to step, and each sweep solves for its viscous response.
// Springs and dampers may couple fluid and markers instead. theory.md (80), (81), (87), (92a)
#pragma once

#include "fluid/stage_forcing.hpp"
#include "immersion/forcing_numbers.hpp"
#include "immersion/given_sums.hpp"
#include "immersion/held_forcing.hpp"
#include "immersion/held_vectors.hpp"
#include "immersion/marker_planes.hpp"
#include "immersion/markers.hpp"
#include "immersion/surface_work.hpp"

#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace skein {

/// Response of a marker in (89) to a stage that begins: `volume` of fluid takes the velocity of the marker.
struct MarkerResponse {
    Vec3d volume;  ///< m^3 by component
    Vec3d impulse; ///< m^4/s, volume times the velocity that the fluid would give a marker without motion of its own
};

/// All results have the same bits on any ranks and threads.
class DirectForcing final : public StageForcing, public HeldForcing {
public:
    /// Sets this rank's markers to their places and velocities at a time. Each marker belongs to one rank.
    using Place = std::function<void(double time, Markers& markers)>;
    /// `moves`: markers change their places with time.
    DirectForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                  const ForcingNumbers& numbers, std::size_t bodies, Place place, bool moves, int across = 1);

    void add_held_forces(const FlowStage& stage) override;
    void sample(const FlowStage& stage) override;
    void apply(const FlowStage& stage) override;
    bool changed(int plane) const override { return planes_.reaches(plane); }

    void find_slips(const FlowStage& stage) override;
    double largest_slip() const override;
    void push(const FlowStage& stage) override;
    void find_response(const FlowStage& stage) override;
    void add_terms(std::array<std::vector<double>, 2>& terms) const override;
    void take(double times, const FlowStage& stage) override;
    void end_sweeps(const FlowStage& stage) override;

    /// Momentum that bodies have given the fluid since its reset().
    GivenSums& given() { return given_; }
    const GivenSums& given() const { return given_; }
    /// Sets the number of parts, which `place` numbers.
    void set_parts(std::size_t parts) {
        given_.set_parts(parts);
        markers_.has_parts = parts > 0;
    }
    /// Finds the work of bodies in each stage from now on.
    void measure_work() { work_.emplace(comm_, grid_.h * grid_.h * grid_.h); }
    std::optional<SurfaceWorkSums>& work() { return work_; }
    const std::optional<SurfaceWorkSums>& work() const { return work_; }
    /// Largest slip of any rank after the last step, before its projection, m/s.
    double slip() const { return largest_slip_; }
    /// Wall time at markers since the last call, without implicit viscosity, s.
    double take_seconds() { return std::exchange(seconds_, 0); }

    /// Markers of this rank. Their velocities may change between sample() and apply().
    Markers& markers() { return markers_; }
    /// Response to the stage that sample() began.
    MarkerResponse response(std::size_t marker) const;
    /// Change at each marker by all sweeps of apply(), m/s, which nearby cells share by their weights.
    const std::vector<Vec3d>& changes() const { return changes_; }

    /// Forces or lengths of springs; empty with explicit viscosity and sweeps.
    const HeldVectors& held() const { return held_; }
    /// Continues from saved() of held(). Not collective.
    void restore_held(std::span<const double> saved);

private:
    /// Puts markers to the time of the stage, unless they rest there. Returns true if it did. Collective.
    bool put_markers(const FlowStage& stage);
    /// Finds the weights of markers at new places. Collective.
    void find_weights(const FlowStage& stage);
    void apply_sweeps(const FlowStage& stage);
    void apply_springs(const FlowStage& stage);
    /// Scales the changes of later sweeps by their shares and spreads the differences. Collective.
    void rescale(const std::vector<std::vector<Vec3d>>& sweeps, const FlowStage& stage);
    /// Shares of a slip that springs and dampers leave and set to 0 in a stage, by component.
    struct SlipShares {
        Vec3d left, set;
    };
    SlipShares shares(std::size_t marker) const;
    /// Interpolates velocities of the fluid to markers. Collective.
    void find_velocities(const FlowStage& stage);
    void subtract_velocities();
    /// Keeps the work of changes_ in an explicit stage, whose slips are found. theory.md (161)
    void keep_work();

    Communicator comm_;
    const Threads& threads_;
    FluidGrid grid_;
    ForcingNumbers numbers_;
    Place place_;
    bool moves_, settled_ = false;
    MarkerPlanes planes_;
    Markers markers_;
    /// Weight of a marker by component: its share over the change that a change of 1 at all markers makes at it. It is
    /// 0 beyond walls, where there is no fluid.
    std::vector<Vec3d> weight_;
    std::vector<Vec3d> velocity_; ///< velocity of the fluid at markers, m/s
    std::vector<Vec3d> slip_;     ///< marker's velocity minus the fluid's, m/s
    std::vector<Vec3d> changes_;  ///< by marker, m/s; pushes of implicit stages
    std::vector<Vec3d> response_; ///< by marker, m/s
    std::vector<Vec3d> at_begin_; ///< velocity of the fluid there at the begin of the stage, m/s, for work_
    GivenSums given_;
    std::optional<SurfaceWorkSums> work_;    ///< absent: nothing needs it
    HeldVectors held_;                       ///< forces of implicit stages, or lengths of springs
    double largest_slip_ = 0, stage_dt_ = 0; ///< m/s; s
    double seconds_ = 0;                     ///< wall time since take_seconds()
};

} // namespace skein
