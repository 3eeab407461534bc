// A small scene whose last bits are known: whether this build computes right on this processor and these ranks.
#pragma once

#include "parallel/communicator.hpp"
#include "parallel/threads.hpp"

#include <cstdint>

namespace skein {

/// Digest of the scene below after its last step, on any ranks, threads, lanes and processors.
inline constexpr std::uint64_t self_check_digest = 0x1e23e00c5389f267;

/// Steps the scene: rods that fall across others on a floor, and a rigid body of all kinds of parts; with friction,
/// damping and a magnetic field; round and elliptic, uniform and tapered. Arithmetic and square roots alone: the
/// mathematical library of the system has no part in it. Less than a second. Collective.
std::uint64_t self_check(const Communicator& comm, const Threads& threads, int lanes);

} // namespace skein
