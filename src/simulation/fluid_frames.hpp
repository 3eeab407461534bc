// Frames of a fluid, as a plan wants them: whole, slices, boxes of means, blocks.
#pragma once

#include "fluid/cell_samples.hpp"
#include "io/field_series.hpp"
#include "parallel/threads.hpp"
#include "scene/fluid_plan.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace skein {

class FluidFrames {
public:
    /// The time of step s is shift + s dt. Collective, as write_due().
    FluidFrames(const Communicator& comm, const Threads& threads, const FlowSolver& flow, const FluidPlan& plan,
                const std::string& directory, double dt, double shift);
    ~FluidFrames();

    /// All that are due at this step, of a box that has moved by `moved`, m.
    void write_due(std::int64_t step, const Vec3d& moved);

private:
    struct Output;
    void write(std::int64_t step, const Vec3d& moved, Output& output);

    FlowPlanes flow_;
    std::vector<Output> outputs_;
};

} // namespace skein
