// Work of bodies on the fluid at their surfaces, for the balance of energy. theory.md (161)
#pragma once

#include "parallel/communicator.hpp"

#include <cstdint>
#include <vector>

namespace skein {

/// Work over density, m^5/s^2.
struct SurfaceWork {
    double given = 0; ///< by bodies
    double lost = 0;  ///< of it, what the fluid's energy does not gain

    SurfaceWork& operator+=(const SurfaceWork& other) {
        given += other.given;
        lost += other.lost;
        return *this;
    }
};

/// Terms of stages stay on their ranks until a row of the series needs the sums. All results have the same bits on any
/// ranks.
class SurfaceWorkSums {
public:
    SurfaceWorkSums(const Communicator& comm, double cell_volume) : comm_(comm), cell_volume_(cell_volume) {}
    /// Adds a term to the present stage, or to the last one added if these two belong to the same row of cells.
    void add(const SurfaceWork& work, bool same_row = false);
    /// Ends a stage. Collective, as every `most_kept` stages sum().
    void end_stage();
    /// Sums what is kept, stage by stage: bits do not depend on when. Collective.
    void sum();
    void reset();
    /// Since reset(), until the last sum().
    const SurfaceWork& whole() const { return whole_; }

private:
    static constexpr std::uint32_t most_kept = 12; ///< stages
    Communicator comm_;
    double cell_volume_; ///< m^3
    std::uint32_t kept_ = 0;
    std::vector<SurfaceWork> terms_;
    std::vector<std::uint32_t> stage_; ///< by term
    SurfaceWork whole_;
};

} // namespace skein
