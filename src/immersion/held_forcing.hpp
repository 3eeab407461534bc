// Forces of bodies that stay from step to step, in stages of implicit viscosity. theory.md (87)
#pragma once

#include "fluid/stage_forcing.hpp"
#include "parallel/communicator.hpp"

#include <array>
#include <span>
#include <vector>

namespace skein {

/// Bodies of one kind. Slips are what their forces are to remove, m/s, and each has a weight.
class HeldForcing {
public:
    virtual ~HeldForcing() = default;
    /// Collective.
    virtual void find_slips(const FlowStage& stage) = 0;
    /// Largest slip of any rank, m/s. Collective.
    virtual double largest_slip() const = 0;
    /// Adds pushes along the weighted slips to the scratch of the stage. Collective.
    virtual void push(const FlowStage& stage) = 0;
    /// Finds the changes of slips by the response in the scratch of the stage. Collective.
    virtual void find_response(const FlowStage& stage) = 0;
    /// Appends weighted terms of slip times response, and of the square of the response.
    virtual void add_terms(std::array<std::vector<double>, 2>& terms) const = 0;
    /// Adds so many times the pushes to the forces, and takes the response off the slips.
    virtual void take(double times, const FlowStage& stage) = 0;
    /// Adds the forces over the stage to the momentum given by bodies. Collective.
    virtual void end_sweeps(const FlowStage& stage) = 0;
};

/// Sweeps, at most so many and until slips are below a limit, that leave the least weighted squares of all slips.
/// Collective.
void sweep_held_forces(const Communicator& comm, const FlowStage& stage, int sweeps, double slip,
                       std::span<HeldForcing* const> of_bodies);

} // namespace skein
