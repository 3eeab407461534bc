// Frames of a fluid, as a plan wants them: whole, slices, boxes of means, blocks.
#pragma once

#include "fluid/cell_samples.hpp"
#include "io/field_series.hpp"
#include "parallel/threads.hpp"
#include "scene/fluid_plan.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace skein {

class FluidFrames {
public:
    /// Earlier frames of a series, by its name, that a resumed run goes on from.
    using Earlier = std::function<FieldSeries::Earlier(const std::string&)>;
    /// The time of step s is shift + s dt. Collective, as all that writes.
    FluidFrames(const Communicator& comm, const Threads& threads, const FlowSolver& flow, const FluidPlan& plan,
                const std::string& directory, double dt, double shift, const Earlier& earlier);
    ~FluidFrames();

    /// The first step after `done` at which one is due.
    std::int64_t next(std::int64_t done) const;
    /// All that are due at this step, of a box that has moved by `moved`, m.
    void write_due(std::int64_t step, const Vec3d& moved) { write(step, moved, true); }
    /// The others, and the names of their files.
    void write_end(std::int64_t step, const Vec3d& moved) { write(step, moved, false); }
    std::vector<std::string> files_of_end(std::int64_t step) const;
    /// Steps of the last frames, by series.
    void mark(std::map<std::string, std::int64_t>& last) const;

private:
    struct Output;
    void write(std::int64_t step, const Vec3d& moved, bool due);
    void write(std::int64_t step, const Vec3d& moved, Output& output);

    FlowPlanes flow_;
    std::vector<Output> outputs_;
};

} // namespace skein
