#include "kernels/kernels.hpp"

#include "core/level.hpp"

namespace skein {

extern "C" const Kernels skein_kernels_w1, skein_kernels_w2;
#if defined(__x86_64__)
extern "C" const Kernels skein_kernels_w4, skein_kernels_w8;
#endif

const Kernels& kernels(int lanes) {
    switch (served_lanes(lanes)) {
#if defined(__x86_64__)
    case 1:
        return skein_kernels_w1;
    case 4:
        return skein_kernels_w4;
    case 8:
        return skein_kernels_w8;
#endif
    default:
        return skein_kernels_w2;
    }
}

Surroundings make_surroundings(const Plan& plan, std::span<const RodGroup> groups) {
    Surroundings around;
    if (plan.contact) around.others = std::make_shared<ContactView>(groups, *plan.contact, plan.contact_laws->materials());
    if (!plan.walls.empty()) around.walls = std::make_shared<Walls>(plan.walls);
    return around;
}

std::unique_ptr<Rods> make_rods(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned,
                                const Threads& threads, Surroundings& around) {
    return kernels(plan.machine.lanes).make_rods(plan, groups, std::move(owned), threads, around);
}

std::unique_ptr<Rods> make_rods(const Plan& plan, std::span<const RodGroup> groups, std::vector<LocalRod> owned,
                                const Threads& threads) {
    Surroundings around = make_surroundings(plan, groups);
    return make_rods(plan, groups, std::move(owned), threads, around);
}

} // namespace skein
