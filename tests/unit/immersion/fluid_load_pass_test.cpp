// Drag of a fluid on slots that holds and bearings leave some motions: it is that of the rates after the kick, and the
// fluid receives the opposite of it.
#include "immersion/fluid_load_pass.hpp"
#include "immersion/rod_surface.hpp"
#include "mechanics/bearing.hpp"
#include "rod/held.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace skein {
namespace {

TEST(FluidLoadPass, DragsWhatMovesAfterTheKick) {
    constexpr double h = 0.3;
    for (const std::string axes : {"x", "z", "xy", "yz", "xyz"}) {
        RodSpec spec = test::simple_rod(3);
        spec.section = {.kind = SectionKind::elliptic, .radius = 0.2, .radius_2 = 0.1};
        spec.hold = {.nodes = {1}, .elements = {1}, .directions = "xz", .axes = axes};
        const RodGroup group(spec, 0, 0, "");
        std::vector<Slot<1>> state = test::shaken_state(group, 0.1, 0.5, 1);
        const RodTile<1> rod = test::tile_of(group, state);
        const Step step{.index = 1, .kick = h};
        const auto hold = [&] {
            apply_hold<1>(group, state.data());
            BearingPass<1>(group, {}).run(rod, nullptr, step);
        };
        hold();

        std::mt19937 random(7);
        std::normal_distribution<double> normal;
        const auto vector = [&] { return Vec3d{normal(random), normal(random), normal(random)}; };
        const auto positive = [&] {
            const Vec3d v = vector();
            return scale(v, v);
        };
        const LocalRod local{0, 0, 0};
        auto loads = std::make_shared<FluidLoads>(std::span(&group, 1), std::span(&local, 1));
        std::vector<SlotLoad<1>> load(state.size());
        for (std::size_t k = 0; k < state.size(); ++k) {
            loads->load[k].push = vector();
            loads->load[k].drag = 100 * positive();
            loads->load[k].couple = vector();
            loads->load[k].turn_drag = positive();
            load[k] = {broadcast<1>(30 * vector()), broadcast<1>(vector()), Pack<1>(1.0)};
        }
        FluidLoadPass<1>(loads, group, InertiaInFluid(group, std::vector<RodMarker>(), 1, false))
            .run(rod, load.data(), step);
        KickPass<KickKind::undamped, 1>({KickConstants(group, {}, h)}).run(rod, load.data(), step);
        hold();

        for (std::size_t k = 0; k < state.size(); ++k) {
            const FluidLoad& of = loads->load[k];
            const Vec3d on_node = of.push - scale(of.drag, lane(state[k].velocity, 0));
            EXPECT_LT(norm(loads->received[k].on_node - h * on_node), 1e-12) << axes << ", node " << k;
            if (k + 1 == state.size()) break;
            const Quaterniond q = lane(state[k].director, 0);
            const Vec3d on_element = of.couple - transpose_times(q, scale(of.turn_drag, lane(state[k].spin, 0)));
            EXPECT_LT(norm(loads->received[k].on_element - h * on_element), 1e-12) << axes << ", element " << k;
        }
    }
}

} // namespace
} // namespace skein
