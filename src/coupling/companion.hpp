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
    /// Columns of rows(): gid, slot and its numbers; or gid, -1 - i, and the i-th of the rows that memory fills.
    static constexpr std::size_t columns = 15;

    /// `remembers`: joints of rods have a memory that steps change, and that theirs differ in.
    explicit Companion(bool remembers = false) : remembers_(remembers) {}

    /// Largest distance of a node from its place in the companion, m, and largest change of that vector in a step.
    struct Apart {
        double now = 0, change = 0;
    };

    /// A step begins: rods get the companion's state, at first their own. Their own one is noted for apart().
    void enter(Rods& rods);
    /// Notes the state of rods at the end of the companion's step.
    void leave(const Rods& rods);
    /// Distance of rods, at the end of their step, from the companion at the end of its.
    Apart apart(const Rods& rods) const;
    /// The end of its step becomes its state.
    void go_on() {
        state_.swap(end_);
        memory_.swap(end_memory_);
    }

    /// A stage of the scene begins: joints may be others, and it takes their memory from the run.
    void begin_stage() { memory_.clear(); }

    /// Its state as rows for a checkpoint, and back from rows of any rods. Collective.
    std::vector<double> rows(const Rods& rods) const;
    void set(const Communicator& comm, const Rods& rods, std::span<const double> rows);

private:
    using States = std::vector<std::vector<Slot<1>>>; ///< by local rod
    static States state_of(const Rods& rods);
    using Memories = std::vector<std::vector<double>>; ///< by local rod
    Memories memory_of(const Rods& rods) const;
    States state_, end_, start_;
    bool remembers_;
    Memories memory_, end_memory_; ///< where rods remember
};

} // namespace skein
