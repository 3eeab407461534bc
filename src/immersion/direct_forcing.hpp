// Direct forcing: within each stage velocities near markers are changed so that the fluid has the velocity of the markers, in a few
// sweeps.                                                                                                      theory.md (80), (81)
#pragma once

#include "fluid/fluid_grid.hpp"
#include "fluid/stage_forcing.hpp"
#include "immersion/delta.hpp"
#include "immersion/markers.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace skein {

struct ForcingNumbers {
    DeltaKind delta = DeltaKind::three_point;
    int sweeps = 2;  ///< at most
    double slip = 0; ///< m/s, at which there are no more
};

/// Sums are made in the order of markers: the same bits on any ranks and threads.
class DirectForcing final : public StageForcing {
public:
    /// `place`: sets markers to where they are at a time; `moves`: it does so more than once.
    DirectForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid, const ForcingNumbers& numbers,
                  std::function<void(double time, Markers& markers)> place, bool moves);

    void apply(const FlowStage& stage) override;
    bool changed(int plane) const override { return !near_[static_cast<std::size_t>(plane)].empty(); }

    /// Volume times velocity that each body has given the fluid since the last call of forget(), m^4/s; the same on all ranks.
    const std::vector<Vec3d>& given() const { return given_; }
    void forget() { std::fill(given_.begin(), given_.end(), Vec3d{0, 0, 0}); }
    /// Largest difference of velocities at markers after the last stage but for its projection, m/s; the same on all ranks.
    double slip() const { return slip_; }

private:
    /// Weights of a marker for a component, along each direction.
    using Support = std::array<DeltaWeights, 3>;
    Support support(std::uint32_t marker, int component) const;
    void settle(const FlowStage& stage);
    double interpolated(const double* field, std::uint32_t marker, int component) const;
    /// Adds `change` of the markers that reach planes of this rank to its cells, plane by plane, in order of markers.
    void spread(const std::array<double*, 3>& fields) const;
    /// Changes of own markers to the ranks that they reach. Collective.
    void share();
    /// Adds the changes of a stage of own markers to what bodies have given. Collective.
    void add_given(const std::vector<Vec3d>& changes);
    bool reaches(std::uint32_t marker, int rank) const;
    int plane_of(std::uint32_t marker) const;

    Communicator comm_;
    const Threads& threads_;
    FluidGrid grid_;
    ForcingNumbers numbers_;
    Slab slab_;
    FieldLayout layout_;
    std::function<void(double, Markers&)> place_;
    bool moves_, settled_ = false;
    Markers markers_;
    std::vector<std::uint32_t> own_;                 ///< markers whose plane is this rank's
    std::vector<std::vector<std::uint32_t>> near_;   ///< by plane of this rank: markers that may reach it, rising
    std::vector<std::vector<std::uint32_t>> shared_; ///< by rank: own markers that reach its planes, rising
    std::vector<std::uint32_t> come_;                ///< markers of others that reach planes here, by rank
    std::vector<Vec3d> change_;                      ///< by marker, of those that reach planes here, m/s
    std::vector<Vec3d> weight_;                      ///< by marker, of own ones
    std::vector<Vec3d> given_;                       ///< by body
    double slip_ = 0;
};

} // namespace skein
