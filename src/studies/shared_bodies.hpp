// Bodies that are solved for together. Where they are of several ranks, every rank has the states of all of them, in
// the order of their numbers, so that all solve the same equations; loads, stiffness and large factors are computed in
// shares.
#pragma once

#include "simulation/world.hpp"

#include <vector>

namespace skein {

/// Bodies by number, with their states slot by slot.
struct SharedBodies {
    static constexpr std::size_t elsewhere = SIZE_MAX;

    std::vector<LocalRod> rods;
    std::vector<std::size_t> local;               ///< place in the world's local(); `elsewhere`: another rank's
    std::vector<std::size_t> first;               ///< slot of each, and behind the last
    std::vector<Slot<1>> slot;                    ///< synchronised
    std::vector<std::vector<double>> wall_memory; ///< empty where no wall acts
    std::vector<std::vector<double>> memory;      ///< all that a run keeps
};

/// These bodies of this rank, places in the world's local(); with `of_all`, those of all ranks, and collective.
SharedBodies share_bodies(const World& world, std::span<const std::size_t> own, bool of_all);

/// The world's groups with the places of all bodies. Collective.
std::vector<RodGroup> groups_of_all(const World& world);

/// Memory of all contacts of all ranks. Collective.
std::vector<SavedContact> contact_memory_of_all(const Communicator& comm, std::vector<SavedContact> own);

} // namespace skein
