// Momentum that bodies give the fluid at markers. Terms of stages stay on their ranks until a row of the series or a
// summary needs the sums, so most steps send nothing for them.
#pragma once

#include "immersion/given_momentum.hpp"
#include "immersion/markers.hpp"
#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace skein {

class GivenSums {
public:
    GivenSums(const Communicator& comm, const Threads& threads, double cell_volume, std::size_t bodies)
        : comm_(comm), threads_(threads), cell_volume_(cell_volume), of_body_(bodies, Vec3d{0, 0, 0}) {}
    /// Sets the number of Markers::part.
    void set_parts(std::size_t parts) { of_part_.resize(parts); }
    bool has_parts() const { return !of_part_.empty(); }

    /// Forgets all.
    void reset();
    /// Keeps the changes of a stage, m/s by marker. Collective, as every `most_kept` stages sums().
    void keep(std::span<const Vec3d> changes, const Markers& markers);
    /// Sums what is kept, stage by stage: bits do not depend on when. Collective.
    void sum();

    /// Momentum over density since reset(), until the last sum(), m^4/s. All ranks have all bodies.
    const std::vector<Vec3d>& of_body() const { return of_body_; }
    /// The same of parts, with moments about their origins: Markers::part, Markers::arm.
    const std::vector<GivenMomentum>& of_part() const { return of_part_; }

private:
    static constexpr std::uint32_t most_kept = 12; ///< stages: 1 kB a marker
    /// Rows of terms, and the number of the sum that each belongs to: all of a stage, then all of the next.
    struct Terms {
        std::vector<double> number;
        std::vector<std::uint32_t> of;
    };
    void forget_kept();
    std::vector<double> sums_of(const Terms& terms, std::size_t columns, std::size_t in_stage) const;

    Communicator comm_;
    const Threads& threads_;
    double cell_volume_;     ///< m^3
    std::uint32_t kept_ = 0; ///< stages
    Terms body_terms_, part_terms_;
    std::vector<Vec3d> of_body_;
    std::vector<GivenMomentum> of_part_;
};

} // namespace skein
