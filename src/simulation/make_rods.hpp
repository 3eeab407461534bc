// From a plan to rods with their passes: the one place where the scene's run-time choices become template arguments.
#pragma once

#include "contact/contact_view.hpp"
#include "contact/wall_book.hpp"
#include "parallel/threads.hpp"
#include "rod/rods.hpp"
#include "scene/plan.hpp"

#include <memory>
#include <span>
#include <vector>

namespace skein {

/// What rods meet besides their own loads, shared by their passes and by Interactions; parts that the plan has no use for are
/// absent.
struct Surroundings {
    std::shared_ptr<ContactView> others;
    std::shared_ptr<Walls> walls;
    std::vector<std::shared_ptr<const WallAccounts>> accounts; ///< by group, once the rods are made; null where no wall acts
};
Surroundings make_surroundings(const Plan& plan, std::span<const RodGroup> groups);

/// Rods at plan.machine.lanes (1, 2, 4 or 8) in their start state. `groups` and `threads` must outlive them.
std::unique_ptr<Rods> make_rods(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned,
                                const Threads& threads, Surroundings& around);
std::unique_ptr<Rods> make_rods(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned,
                                const Threads& threads);

} // namespace skein
