// A second run of the same rods beside the run itself, in coarser steps: its distance estimates the error of the run.
#pragma once

#include "parallel/communicator.hpp"
#include "tiles/rods.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace skein {

class Companion {
public:
    static constexpr std::size_t columns = 15; ///< of rows(): gid, slot and its numbers

    /// Largest distance of a node from its place in the companion, m, and largest change of that vector in a step.
    struct Apart {
        double now = 0, change = 0;
    };

    /// A step begins: rods get the companion's state, at first their own. Their own one is noted for apart().
    void enter(Rods& rods);
    /// Notes the state of rods at the end of the companion's step.
    void leave(const Rods& rods) { end_ = state_of(rods); }
    /// Distance of rods, at the end of their step, from the companion at the end of its.
    Apart apart(const Rods& rods) const;
    /// The end of its step becomes its state.
    void go_on() { state_.swap(end_); }

    /// Its state as rows for a checkpoint, and back from rows of any rods. Collective.
    std::vector<double> rows(const Rods& rods) const;
    void set(const Communicator& comm, const Rods& rods, std::span<const double> rows);

private:
    using States = std::vector<std::vector<Slot<1>>>; ///< by local rod
    static States state_of(const Rods& rods);
    States state_, end_, start_;
};

} // namespace skein
