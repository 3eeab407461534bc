// Bodies with sharp surfaces: each stage sets velocities of nodes within them, and nodes next to them get an implicit
// change of the centre weight of the Laplacian. theory.md (129)
#pragma once

#include "fluid/stage_forcing.hpp"
#include "immersion/sharp_nodes.hpp"
#include "parallel/communicator.hpp"

#include <utility>
#include <vector>

namespace skein {

/// All results have the same bits on any ranks and threads.
class SharpForcing {
public:
    SharpForcing(const Communicator& comm, const Threads& threads, const FluidGrid& grid, double kinematic_viscosity,
                 std::vector<SharpBody> bodies, int across = 1);

    /// Changes velocities of an explicit stage before its markers act. Collective.
    void act(const FlowStage& stage);
    bool changed(int plane) const { return nodes_.reaches(plane); }

    /// Momentum over density that each body has given the fluid since reset_given(), m^4/s. All ranks have all bodies.
    const std::vector<Vec3d>& given() const { return given_; }
    void reset_given() { std::fill(given_.begin(), given_.end(), Vec3d{0, 0, 0}); }
    /// Wall time since the last call, s.
    double take_seconds() { return std::exchange(seconds_, 0); }

private:
    /// Sum of changes of nodes of a row by one body, m/s.
    struct RowSum {
        double change;
        std::uint32_t of; ///< 3 body + component
    };
    /// Changes the nodes of a list and appends the sums of its rows.
    void act_on(std::span<const SharpNode> nodes, const FlowStage& stage, std::vector<RowSum>& sums) const;
    /// Adds the changes of all rows to the momentum given by bodies. Collective.
    void add_given(const std::vector<std::vector<RowSum>>& of_planes);

    /// Change of a node by its neighbours and a body at the begin of the stage, m/s.
    double pull_of(const SharpNode& node, const FlowStage& stage) const;

    Communicator comm_;
    const Threads& threads_;
    double h_, viscosity_;
    FieldLayout layout_;
    SharpNodes nodes_;
    std::vector<Vec3d> given_;
    double seconds_ = 0;
};

} // namespace skein
