#include "simulation/make_rods.hpp"

#include "core/error.hpp"
#include "simulation/make_rods_at.hpp"

namespace skein {

Surroundings make_surroundings(const Plan& plan, std::span<const RodGroup> groups) {
    Surroundings around;
    if (plan.contact) around.others = std::make_shared<ContactView>(groups, *plan.contact, plan.contact_laws->materials());
    if (!plan.walls.empty()) around.walls = std::make_shared<Walls>(plan.walls);
    return around;
}

std::unique_ptr<Rods> make_rods(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned,
                                const Threads& threads, Surroundings& around) {
    switch (plan.machine.lanes) {
    case 1:
        return make_rods_at<1>(plan, groups, std::move(owned), threads, around);
    case 2:
        return make_rods_at<2>(plan, groups, std::move(owned), threads, around);
    case 4:
        return make_rods_at<4>(plan, groups, std::move(owned), threads, around);
    case 8:
        return make_rods_at<8>(plan, groups, std::move(owned), threads, around);
    default:
        throw InputError("lanes must be 1, 2, 4 or 8, not " + std::to_string(plan.machine.lanes));
    }
}

std::unique_ptr<Rods> make_rods(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned,
                                const Threads& threads) {
    Surroundings around = make_surroundings(plan, groups);
    return make_rods(plan, groups, std::move(owned), threads, around);
}

} // namespace skein
