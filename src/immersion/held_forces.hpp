// Forces that markers go on with from one step to the next, wherever the ranks are that hold them.
#pragma once

#include "parallel/communicator.hpp"
#include "skein/core/vec3.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

class HeldForces {
public:
    /// Numbers of a marker in kept(): identity, force.
    static constexpr std::size_t record = 4;

    /// This rank holds markers with these identities from now on; those that no rank held before have no force. Collective.
    void settle(const Communicator& comm, std::span<const std::int64_t> identities);

    /// m/s^2 at markers of weight 1 (of springs: m), in the order of settle().
    std::span<Vec3d> forces() { return forces_; }
    std::span<const Vec3d> forces() const { return forces_; }
    std::span<const std::int64_t> identities() const { return identities_; }

    /// Of the markers of all ranks, by identity. Collective.
    std::vector<double> kept(const Communicator& comm) const;
    /// Goes on from these; settle() follows. This rank alone.
    void recall(const Communicator& comm, std::span<const double> kept);

private:
    std::vector<std::int64_t> identities_;
    std::vector<Vec3d> forces_;
};

} // namespace skein
