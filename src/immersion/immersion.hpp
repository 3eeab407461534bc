// Bodies in a fluid: obstacles, whose motion is given, and rods.
#pragma once

#include "immersion/direct_forcing.hpp"
#include "immersion/force_balance.hpp"
#include "immersion/immersed_rods.hpp"
#include "immersion/obstacle.hpp"

#include <memory>
#include <utility>
#include <vector>

namespace skein {

class Immersion {
public:
    /// `rods`: null where there are none; `across`: ranks that share the rows of a slab.
    Immersion(const Communicator& comm, const Threads& threads, const FluidGrid& grid, const ForcingNumbers& numbers,
              std::vector<Obstacle> obstacles, std::unique_ptr<ImmersedRods> rods = nullptr, int across = 1);

    DirectForcing& forcing() { return forcing_; }
    const DirectForcing& forcing() const { return forcing_; }
    ImmersedRods* rods() { return rods_.get(); }
    const std::vector<Obstacle>& obstacles() const { return obstacles_; }
    /// Positions of rods are so far behind their rates, s.
    void set_lag(double lag) { lag_ = lag; }
    double lag() const { return lag_; }
    /// The box of the fluid, whose grid stays where it was, has moved so far with the rods, m.
    void set_box_shift(const Vec3d& shift) { box_shift_ = shift; }

    /// Rods feel the fluid from now on.
    void feel(std::unique_ptr<ForceBalance> balance) { balance_ = std::move(balance); }
    ForceBalance* balance() { return balance_.get(); }
    const ForceBalance* balance() const { return balance_.get(); }
    /// Where rods feel it: markers stand where they will be at the end of a stage, by their velocities now. Around
    /// FlowSolver::begin_stage.
    void expect_stage(const ForceBalance::Stage& stage) { ahead_ = stage.length; }
    void begin_stage(const ForceBalance::Stage& stage);
    /// Around FlowSolver::end_stage, when rods have come there.
    void come_to_end(const ForceBalance::Stage& stage);
    void end_stage();

    /// Since the last call of begin_interval(), by a fluid of this density: the mean force on an obstacle, N.
    Vec3d force_on_obstacle(std::size_t obstacle, double density, double time) const;
    /// The same on the rods of a group, with what the fluid within their surfaces takes to move with them.
    Vec3d force_on_rods(std::size_t group, double density, double time) const;
    void begin_interval(double time) {
        forcing_.forget();
        from_ = time;
    }

    /// Wall time spent at markers since the last call, s.
    double take_seconds() { return std::exchange(seconds_, 0) + forcing_.take_seconds(); }

private:
    void place(double time, Markers& markers) const;
    void place_obstacles(double time, Markers& markers) const;
    /// Of markers, those of own rods, which come behind those of obstacles.
    template <class Vectors> auto of_rods(Vectors& of_markers) const {
        return std::span(of_markers).last(rods_->count());
    }

    FluidGrid grid_;
    int rank_;
    Pencils pencils_;
    std::vector<Obstacle> obstacles_;
    std::vector<std::vector<Vec3d>> about_centre_; ///< markers of obstacles
    std::int64_t obstacle_markers_ = 0;
    std::unique_ptr<ImmersedRods> rods_;
    DirectForcing forcing_;
    std::unique_ptr<ForceBalance> balance_; ///< null where rods do not feel the fluid
    double from_ = 0, lag_ = 0, ahead_ = 0; ///< s
    Vec3d box_shift_{0, 0, 0};
    double seconds_ = 0; ///< not told yet, but for those of forcing_
};

} // namespace skein
