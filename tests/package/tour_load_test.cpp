// The load of docs/tour.md, in the tree as the page tells.
#include "loads/load_pass.hpp"
#include "loads/wind.hpp"
#include "plan/plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_file.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

namespace skein {
namespace {

constexpr int lanes = SKEIN_WIDTH;
constexpr Vec3d u{3, -1, 0.5};
constexpr double c = 0.7;

SceneSpec scene(const std::string& load) {
    const std::string text = R"(
        time.duration = 0.1
        [[rods]]
        name = "rod"
        material = {density = 1000, youngs_modulus = 1e6}
        section.radius = 0.01
        shape = {length = 1, elements = 8}
    )";
    return parse_scene("tour", text + load);
}

std::string wind(double drag) {
    return "[[load]]\nkind = \"wind\"\nvelocity = [3, 0, 0]\ndrag = " + std::to_string(drag);
}

Plan plan_of(const SceneSpec& spec) { return make_plan(spec, make_groups(spec), {}); }

/// c l_i (u - v_i)
Vec3d force(const RodGroup& group, const std::vector<Slot<1>>& state, std::size_t i) {
    return c * group.node_length[i] * (u - lane(state[i].velocity, 0));
}

void expect_near(const Vec3d& a, const Vec3d& b) { EXPECT_LT(norm(a - b), 1e-15) << a.x << " " << a.y << " " << a.z; }

template <class Text> bool contains(const std::vector<Text>& all, std::string_view one) {
    return std::find(all.begin(), all.end(), one) != all.end();
}

TEST(TourLoad, IsDescribed) {
    const std::string text = describe_key("load.wind");
    EXPECT_NE(text.find("load.wind.velocity [m/s]: of the air, lab frame (3 numbers, required)"), std::string::npos)
        << text;
    EXPECT_NE(text.find("load.wind.drag [kg/(m s)]"), std::string::npos) << text;
}

TEST(TourLoad, IsReadAndChecked) {
    const SceneSpec good = scene(wind(0.5));
    EXPECT_EQ(good.loads.at(0).load.as<Wind>().drag, 0.5);
    try {
        scene(wind(-1));
        FAIL() << "a negative drag was taken";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("drag"), std::string::npos) << e.what();
    }
}

TEST(TourLoad, IsInThePlan) {
    const Plan with = plan_of(scene(wind(0.5))), without = plan_of(scene(""));
    EXPECT_TRUE(contains(with.groups[0].program.names(), "wind"));
    EXPECT_FALSE(contains(without.groups[0].program.names(), "wind"));
}

TEST(TourLoad, LimitsTheStep) {
    const Plan plan = plan_of(scene(wind(1000)));
    EXPECT_EQ(plan.groups[0].limits.front().mode, "wind");
    const double mass_per_length = 1000 * 3.14159265358979 * 1e-4;
    EXPECT_LT(plan.limit, 2 / (1000 / mass_per_length)) << "of an explicit drag";
}

TEST(TourLoad, IsItsFormulaInEveryLane) {
    const RodGroup group(test::crooked_rod(9), 0, 0, "");
    std::vector<std::vector<Slot<1>>> states;
    std::vector<Slot<lanes>> slot(static_cast<std::size_t>(group.slots()));
    for (int i = 0; i < lanes; ++i) {
        states.push_back(test::shaken_state(group, 0.02, 0.4, 1, static_cast<unsigned>(i + 1)));
        for (std::size_t k = 0; k < slot.size(); ++k) set_lane(slot[k], i, states.back()[k]);
    }
    const RodTile<lanes> tile{slot.data(), group.element.data(), group.voronoi.data(), &group, group.elements(), 0, {},
                              lanes};
    std::vector<SlotLoad<lanes>> load(slot.size());
    make_pass<lanes>(Wind{.velocity = u, .drag = c}, group)->run(tile, load.data(), Step{});
    for (int i = 0; i < lanes; ++i)
        for (std::size_t k = 0; k < slot.size(); ++k)
            expect_near(lane(load[k].force, i), force(group, nth(states, i), k));
}

TEST(TourLoad, HasTheSameBitsAlong) {
    constexpr int rows = 3;
    const RodGroup group(test::crooked_rod(rows * lanes), 0, 0, "");
    std::vector<Slot<1>> state = test::shaken_state(group, 0.02, 0.4, 1);
    const LaneRange range{&group, 0, 0, lanes};
    const Strands<lanes> strands(std::span(&range, 1), rows);
    std::vector<Slot<lanes>> slot(rows + 1);
    for (int row = 0; row <= rows; ++row)
        for (int i = 0; i < lanes; ++i)
            if (const int at = strands.slot(i, row); at >= 0) set_lane(nth(slot, row), i, nth(state, at));
    const RodTile<lanes> tile{.slot = slot.data(), .group = &group, .n = rows, .lanes = lanes, .strands = &strands};
    join(tile);
    std::vector<SlotLoad<lanes>> along(slot.size());
    const Wind wind{.velocity = u, .drag = c};
    make_pass<lanes, Along<lanes>>(wind, group)->run(tile, along.data(), Step{});
    std::vector<SlotLoad<1>> across(state.size());
    wind.add(tile_of(group, state), across.data(), Step{});

    for (int k = 0; k < group.slots(); ++k) {
        const auto [row, i] = strands.place(0, k);
        const Vec3d a = lane(nth(along, row).force, i), b = lane(nth(across, k).force, 0);
        EXPECT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z) << k;
    }
    for (int i = 0; i + 1 < lanes; ++i)
        EXPECT_TRUE(zero(lane(along[rows].force, i))) << "a node that the next lane has too";
}

TEST(TourLoad, PullsTheNodeThatClosesARingOnce) {
    RodSpec spec = test::simple_rod(8);
    spec.shape.closed = true;
    spec.shape.rest_curvature = {0, 2 * 3.14159265358979, 0};
    const RodGroup group(spec, 0, 0, "");
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    group.start_state(0, state);
    std::vector<SlotLoad<1>> load(state.size());
    const Wind wind{.velocity = u, .drag = c};
    wind.add(tile_of(group, state), load.data(), Step{});
    Vec3d sum{0, 0, 0};
    for (const SlotLoad<1>& node : load) sum += lane(node.force, 0);
    EXPECT_LT(norm(sum - c * u), 1e-14) << "of a ring of length 1";
}

} // namespace
} // namespace skein
