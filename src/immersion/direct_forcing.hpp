// Direct forcing: within each stage velocities near markers are changed so that the fluid has the velocity of the
// markers, in a few sweeps. Where viscosity is implicit, forces at markers stay from step to step, and each sweep
// solves for what viscosity makes of its part. Instead, springs and dampers may pull fluid and markers together.
// theory.md (80), (81), (87), (92a)
#pragma once

#include "fluid/stage_forcing.hpp"
#include "immersion/held_vectors.hpp"
#include "immersion/marker_planes.hpp"
#include "immersion/markers.hpp"

#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace skein {

struct ForcingNumbers {
    DeltaKind delta = DeltaKind::three_point;
    int sweeps = 2;  ///< at most
    double slip = 0; ///< m/s, at which there are no more
    /// Of springs and dampers in place of sweeps, per area and density of the fluid: 1/s^2 and 1/s, times m. 0: sweeps.
    double stiffness = 0, damping = 0;
    bool felt = false; ///< rods feel the fluid: sweeps have the shares of sweep_shares()

    bool penalty() const { return stiffness > 0 || damping > 0; }
};

/// The same bits on any ranks and threads.
class DirectForcing final : public StageForcing {
public:
    /// Sets the markers of this rank to those of a time; each is one rank's.
    using Place = std::function<void(double time, Markers& markers)>;
    /// `moves`: markers are elsewhere at other times.
    DirectForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid,
                  const ForcingNumbers& numbers, std::size_t bodies, Place place, bool moves, int across = 1);

    void hold(const FlowStage& stage) override;
    void meet(const FlowStage& stage) override;
    void apply(const FlowStage& stage) override;
    bool changed(int plane) const override { return planes_.reaches(plane); }

    /// Volume times velocity that each body has given the fluid since the last call of forget(), m^4/s; the same on all
    /// ranks.
    const std::vector<Vec3d>& given() const { return given_; }
    void forget() { std::fill(given_.begin(), given_.end(), Vec3d{0, 0, 0}); }
    /// Largest difference of velocities at markers after the last step but for its projection, m/s; the same on all
    /// ranks.
    double slip() const { return slip_; }
    /// Wall time spent at markers since the last call, but for implicit viscosity, s.
    double take_seconds() { return std::exchange(seconds_, 0); }

    /// Of this rank; between meet() and apply() their velocities may be changed.
    Markers& markers() { return markers_; }
    /// What markers answer to the fluid in the stage that meet() began: volume of fluid that takes up their velocity,
    /// m^3 by component, and that times the velocity they would have without a motion of their own, m^4/s.
    struct Answer {
        Vec3d volume, impulse;
    };
    Answer answer(std::size_t marker) const;
    /// What apply() changed at markers in all of its sweeps, m/s at a marker: each cell near it by its share.
    const std::vector<Vec3d>& changes() const { return changes_; }

    /// None where viscosity is explicit.
    const HeldVectors& held() const { return held_; }
    /// Goes on from what saved() of held() was. This rank alone.
    void recall_held(std::span<const double> kept);

private:
    void settle(const FlowStage& stage);
    void apply_implicitly(const FlowStage& stage);
    void apply_springs(const FlowStage& stage);
    /// Of a slip without springs and dampers, what is left and what they set to 0 in the stage that meet() began; by
    /// component.
    struct SlipShares {
        Vec3d left, set;
    };
    SlipShares shares(std::size_t marker) const;
    /// By how many times this answer to a push the slips become least, in the mean of their squares over what is
    /// forced. Collective.
    double least_slips(std::span<const Vec3d> answer) const;
    /// Velocities of the fluid at markers; and those of markers less them. Collective.
    void find_velocities(const FlowStage& stage);
    void find_differences(const FlowStage& stage);
    void subtract_found();
    /// At the end of a step. Collective.
    void note_slip(const FlowStage& stage);
    /// The largest of them on any rank, m/s. Collective.
    double largest_difference() const;
    /// Adds the changes of a stage to what bodies have given. Collective.
    void add_given(const std::vector<Vec3d>& changes);

    Communicator comm_;
    const Threads& threads_;
    FluidGrid grid_;
    ForcingNumbers numbers_;
    Place place_;
    bool moves_, settled_ = false;
    MarkerPlanes planes_;
    Markers markers_;
    /// Of markers, by component: by what a change of all by 1 is to be multiplied for 1 to come of it; 0 beyond walls,
    /// where there is no fluid.
    std::vector<Vec3d> weight_;
    std::vector<Vec3d> found_;      ///< velocities of the fluid at markers, m/s
    std::vector<Vec3d> difference_; ///< of markers, m/s
    std::vector<Vec3d> changes_;    ///< of markers, m/s
    std::vector<Vec3d> given_;      ///< by body
    HeldVectors held_;              ///< forces of implicit stages; lengths of springs
    double slip_ = 0, stage_ = 0;   ///< m/s; length of the stage, s
    double seconds_ = 0;            ///< not told yet
};

} // namespace skein
