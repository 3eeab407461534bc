// What markers go on with from one step to the next, wherever the ranks are that hold them: forces, m/s^2 at markers of
// weight 1, of implicit viscosity, or lengths of springs, m.
#pragma once

#include "parallel/communicator.hpp"
#include "skein/core/vec3.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace skein {

class HeldVectors {
public:
    /// Numbers of a marker in saved(): identity, vector.
    static constexpr std::size_t record = 4;

    /// This rank holds markers with these identities from now on; those that no rank held before have 0. Collective.
    void settle(const Communicator& comm, std::span<const std::int64_t> identities);

    /// In the order of settle().
    std::span<Vec3d> values() { return values_; }
    std::span<const Vec3d> values() const { return values_; }
    std::span<const std::int64_t> identities() const { return identities_; }

    /// Of the markers of all ranks, by identity. Collective.
    std::vector<double> saved(const Communicator& comm) const;
    /// Goes on from these; settle() follows. This rank alone.
    void restore(const Communicator& comm, std::span<const double> kept);

private:
    std::vector<std::int64_t> identities_;
    std::vector<Vec3d> values_;
};

} // namespace skein
