#include "kernels/kernels.hpp"

#include "core/level.hpp"
#include "skein/core/error.hpp"
#include "tiles/clusters.hpp"

#include <iterator>

#include <fmt/format.h>

namespace skein {

extern "C" const Kernels skein_kernels_w1, skein_kernels_w2, skein_kernels_w4, skein_kernels_w8;

const Kernels& kernels(int lanes) {
    struct Built {
        int lanes;
        const Kernels* kernels;
    };
    // The narrowest stands last, for those who ask for less.
    static constexpr Built built[] = {
#if defined(SKEIN_HAS_W8) && defined(__x86_64__)
        {8, &skein_kernels_w8},
#endif
#if defined(SKEIN_HAS_W4) && defined(__x86_64__)
        {4, &skein_kernels_w4},
#endif
#if defined(SKEIN_HAS_W2) || !defined(__x86_64__)
        {2, &skein_kernels_w2},
#endif
#if defined(SKEIN_HAS_W1) && defined(__x86_64__)
        {1, &skein_kernels_w1},
#endif
    };
    const int served = served_lanes(lanes);
    for (const Built& b : built)
        if (b.lanes <= served && served_lanes(b.lanes) == b.lanes) return *b.kernels;
    const Built& narrowest = std::end(built)[-1];
    if (served_lanes(narrowest.lanes) != narrowest.lanes)
        throw InputError(
            fmt::format("this program has kernels for processors of {} and later alone, and this one is of an "
                        "earlier kind; cmake -B build -DSKEIN_WIDTHS=\"1;2;4;8\" builds those of all",
                        level_name(narrowest.lanes)));
    return *narrowest.kernels;
}

namespace {

/// `owned`: in the order of their tiles.
Surroundings make_surroundings(const Plan& plan, std::span<const RodGroup> groups, std::span<const LocalRod> owned,
                               std::shared_ptr<Walls> walls) {
    Surroundings around;
    around.walls = std::move(walls);
    if (plan.acts_between_rods()) {
        around.exposure = std::make_shared<Exposure>(groups, owned);
        around.loads = std::make_shared<SlotLoads>();
    }
    for (const auto& physics : plan.physics)
        if (const auto* one = dynamic_cast<const SharesWithPasses*>(physics.get())) one->share(around, groups, owned);
    return around;
}

} // namespace

std::unique_ptr<Rods> make_rods(const Plan& plan, std::span<const RodGroup> groups, std::span<const LocalRod> owned,
                                const Threads& threads, Surroundings& around) {
    const Kernels& of_plan = kernels(plan.machine.lanes);
    std::vector<LocalRod> ordered;
    for (const std::size_t i : order_of_tiles(groups, owned, of_plan.lanes, threads.count()))
        ordered.push_back(owned[i]);
    around = make_surroundings(plan, groups, ordered, std::move(around.walls));
    return of_plan.make_rods(plan, groups, std::move(ordered), threads, around);
}

std::unique_ptr<StaticRods> make_static_rods(const Plan& plan, std::span<const RodGroup> groups,
                                             std::span<const LocalRod> owned, std::shared_ptr<Walls> walls) {
    const Surroundings around = make_surroundings(plan, groups, owned, std::move(walls));
    return kernels(plan.machine.lanes).make_static_rods(plan, groups, owned, around);
}

std::unique_ptr<Rods> make_rods(const Plan& plan, std::span<const RodGroup> groups, std::span<const LocalRod> owned,
                                const Threads& threads) {
    Surroundings around;
    return make_rods(plan, groups, owned, threads, around);
}

} // namespace skein
