// Vectors that markers carry from step to step, on whichever rank holds them. These are forces of implicit viscosity,
// m/s^2 at markers of weight 1, or lengths of springs, m.
#pragma once

#include "parallel/communicator.hpp"
#include "skein/core/vec3.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

class HeldVectors {
public:
    /// Numbers of a marker in saved(): identity and vector.
    static constexpr std::size_t record = 4;

    /// Moves vectors to the ranks that hold these markers from now on. New markers start with 0. Collective.
    void settle(const Communicator& comm, std::span<const std::int64_t> identities);

    /// Vectors in the order of settle().
    std::span<Vec3d> values() { return values_; }
    std::span<const Vec3d> values() const { return values_; }
    std::span<const std::int64_t> identities() const { return identities_; }

    /// Records of the markers of all ranks, by identity. Collective.
    std::vector<double> saved(const Communicator& comm) const;
    /// Continues from records of saved(); settle() must follow. Not collective.
    void restore(const Communicator& comm, std::span<const double> saved);

private:
    std::vector<std::int64_t> identities_;
    std::vector<Vec3d> values_;
};

} // namespace skein
