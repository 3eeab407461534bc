// Kernels of one level of instructions: what a run calls through pointers, all else of them being hidden from the rest
// of the program (cmake/SkeinKernels.cmake). Nothing here depends on the width of packs.
#pragma once

#include "contact/contact_solver.hpp"
#include "contact/static_contacts.hpp"
#include "fluid/flow.hpp"
#include "kernels/static_rods.hpp"
#include "kernels/surroundings.hpp"
#include "parallel/threads.hpp"
#include "plan/plan.hpp"
#include "tiles/rods.hpp"

#include <memory>
#include <span>
#include <vector>

namespace skein {

struct Kernels {
    int lanes;
    /// `owned`: in the order of their tiles.
    std::unique_ptr<Rods> (*make_rods)(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned,
                                       const Threads& threads, Surroundings& around);
    std::unique_ptr<ContactSolver> (*make_contacts)(ContactScene scene, const Threads& threads);
    /// Throws InputError where Skein was built without the fluid.
    std::unique_ptr<FlowSolver> (*make_flow)(const Communicator& comm, const Threads& threads,
                                             const FlowConstants& constants);
    std::unique_ptr<StaticRods> (*make_static_rods)(const Plan& plan, std::span<const RodGroup> groups,
                                                    std::span<const LocalRod> owned, const Surroundings& around);
    std::unique_ptr<StaticContacts> (*make_static_contacts)(ContactScene scene, std::span<const RodGroup> groups,
                                                            std::span<const LocalRod> rods, const Threads& threads);
};

/// Kernels of the level with so many lanes, or of the widest that this processor runs where that is less.
const Kernels& kernels(int lanes);

/// Rods of the plan's lanes in their start state, put in the order of their tiles. `groups` and `threads` must outlive
/// them. `around` becomes what they share with interactions; walls that are there go on.
std::unique_ptr<Rods> make_rods(const Plan& plan, std::span<const RodGroup> groups, std::span<const LocalRod> owned,
                                const Threads& threads, Surroundings& around);
/// The same bodies at rest, which need walls and joints alone.
std::unique_ptr<StaticRods> make_static_rods(const Plan& plan, std::span<const RodGroup> groups,
                                             std::span<const LocalRod> owned, std::shared_ptr<Walls> walls);
/// Rods without surroundings.
std::unique_ptr<Rods> make_rods(const Plan& plan, std::span<const RodGroup> groups, std::span<const LocalRod> owned,
                                const Threads& threads);

} // namespace skein
