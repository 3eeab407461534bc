// Loads as values: what holds for all of the list, and how members that a load may leave out are found.
#include "loads/load_list.hpp"
#include "loads/load_pass.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace skein {
namespace {

/// Writes down what is said; the keys `given` are set.
struct Told : Objections {
    std::set<std::string, std::less<>> given_keys;
    std::vector<std::string> keys, messages;
    void add(std::string_view key, const std::string& message) override {
        keys.emplace_back(key);
        messages.push_back(message);
    }
    bool given(std::string_view key) const override { return given_keys.contains(key); }
};

/// A load with nothing but what it must have; without a mapping.
struct Bare {
    static constexpr std::string_view kind = "of_no_use";
    double strength = 1;
    void fields(FieldVisitor& f) { f.visit({.name = "strength", .unit = "N", .text = ""}, strength); }
    template <int W> void add(const RodTile<W>&, SlotLoad<W>* load, const Step&) const {
        load[0].force.x += Pack<W>(strength);
    }
};

/// A load with all that it may have.
struct Full : Bare {
    static constexpr std::string_view kind = "full", label = "in full";
    static constexpr bool acts_last = true, for_rigid_bodies = false, for_rings = false;
    void check(RodSpecs groups, Objections& objections) const {
        objections.add("strength", std::to_string(groups.size()));
        objections.unused({"given", "not_given"}, "here");
        objections.length("list", 1, 2, "one for each end");
    }
    bool acts_on(const RodSpec& rods) const { return rods.name == "rod"; }
    DragRate largest_rate(const RodGroup& group) const { return {strength, group.elements() - 1}; }
    void bind_group(const RodGroup& group) { strength = group.elements(); }
    template <int W, class Map = Across<W>> void add(const RodTile<W>&, SlotLoad<W>*, const Step&) const {}
};

TEST(AnyLoad, OfTheListIsFoundByItsName) {
    const auto kinds = load_kinds();
    ASSERT_GT(kinds.size(), 5u);
    std::set<std::string_view> labels;
    for (int i = 0; i < static_cast<int>(kinds.size()); ++i) {
        const Load load = make_load(i);
        EXPECT_EQ(load.kind(), nth(kinds, i));
        EXPECT_EQ(load.number(), i);
        EXPECT_EQ(load.label().find('_'), std::string_view::npos) << load.label();
        labels.insert(load.label());
    }
    EXPECT_EQ(labels.size(), kinds.size());
    EXPECT_EQ(Load().number(), 0);
}

TEST(AnyLoad, OfTheListObjectsToRodsThatItIsNotFor) {
    RodSpec body = test::rigid_body(0.1, 0.01), ring = test::simple_rod();
    ring.shape.closed = true;
    const auto objects = [](const Load& load, const RodSpec& rods, const std::string& to) {
        Told told;
        told.given_keys = {"rods"};
        const RodSpec* group = &rods;
        load.check(std::span(&group, 1), told);
        for (std::size_t i = 0; i < told.messages.size(); ++i)
            if (told.messages[i].starts_with("a load of kind " + std::string(load.kind())) &&
                told.messages[i].find(to) != std::string::npos)
                return told.keys[i] == "rods" && told.messages[i].find("'" + rods.name + "'") != std::string::npos;
        return false;
    };
    for (int i = 0; i < static_cast<int>(load_kinds().size()); ++i) {
        const Load load = make_load(i);
        const bool of_bends = load.get_if<MuscleWave>() || load.get_if<MuscleTorques>() ||
                              load.get_if<SlenderBodyDrag>() || load.get_if<PlaneFriction>() ||
                              load.get_if<FormulaLoad>() || load.get_if<MagneticFormula>() ||
                              load.get_if<MuscleFormula>();
        const bool of_ends = load.get_if<EndForce>() || load.get_if<EndCouple>() || load.get_if<SinusoidalEndForce>() ||
                             load.get_if<PlaneFriction>() || load.get_if<Guide>();
        EXPECT_EQ(objects(load, body, "rigid bodies"), of_bends || of_ends) << load.kind();
        EXPECT_EQ(objects(load, ring, "rings"), of_ends) << load.kind();
    }
}

TEST(AnyLoad, CopiesAreOfTheirOwn) {
    Load one = Gravity{.acceleration = {1, 2, 3}}, other = one;
    other.as<Gravity>().acceleration.x = 7;
    EXPECT_EQ(one.as<Gravity>().acceleration.x, 1);
    one = other;
    other = UniformForce{};
    EXPECT_EQ(one.as<Gravity>().acceleration.x, 7);
    EXPECT_EQ(other.kind(), "uniform_force");
    EXPECT_EQ(other.get_if<Gravity>(), nullptr);
}

TEST(AnyLoad, MayLeaveAllButItsForceOut) {
    const RodGroup group(test::simple_rod(8), 0, 0, "");
    const Load load = Bare{};
    EXPECT_EQ(load.label(), "of no use");
    EXPECT_TRUE(load.needs_whole_rods()) << "its add() takes no mapping";
    EXPECT_FALSE(load.acts_last() || load.keeps_tables_of_group());
    EXPECT_TRUE(load.acts_on(group.spec()));
    EXPECT_EQ(load.largest_rate(group).value, 0);
    Told told;
    const RodSpec body = test::rigid_body(0.1, 0.01), *groups[] = {&body};
    load.check(groups, told);
    EXPECT_TRUE(told.messages.empty());

    std::vector<Slot<1>> state = test::shaken_state(group, 0, 0, 0);
    std::vector<SlotLoad<1>> loads(state.size());
    LoadPass<Bare, 1>(Bare{}, group).run(tile_of(group, state), loads.data(), Step{});
    EXPECT_EQ(loads[0].force.x[0], 1);
}

TEST(AnyLoad, IsAskedForWhatItHas) {
    const RodGroup group(test::simple_rod(8), 0, 0, "");
    const Load load = Full{};
    EXPECT_EQ(load.label(), "in full");
    EXPECT_FALSE(load.needs_whole_rods());
    EXPECT_TRUE(load.acts_last() && load.keeps_tables_of_group());
    EXPECT_TRUE(load.acts_on(group.spec()));
    RodSpec other = group.spec();
    other.name = "other";
    EXPECT_FALSE(load.acts_on(other));
    EXPECT_EQ(load.largest_rate(group).value, 1);
    EXPECT_EQ(load.largest_rate(group).element, 7);
    Told told;
    told.given_keys = {"given"};
    const RodSpec* groups[] = {&group.spec(), &other};
    load.check(groups, told);
    EXPECT_EQ(told.keys, (std::vector<std::string>{"strength", "given", "list"}));
    EXPECT_EQ(told.messages, (std::vector<std::string>{"2", "'given' has no use here",
                                                       "'list' has 1 value, but needs 2: one for each end"}));
}

} // namespace
} // namespace skein
