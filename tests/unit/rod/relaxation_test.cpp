// The pass that relaxes rods: its answer to small forces, what it holds, and rods that move against their forces.
#include "mechanics/drift.hpp"
#include "relaxation/relaxation.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

namespace skein {
namespace {

constexpr Step step{.index = 1,
                    .dt = 1,
                    .drift = 1,
                    .kick = 1,
                    .time = 0.5,
                    .kick_length = 0,
                    .slot = 0,
                    .completes = true,
                    .last = true};

/// A rod with what a step needs of it.
struct Relaxing {
    RodGroup group;
    std::vector<Slot<1>> state;
    std::vector<SlotLoad<1>> load;
    std::shared_ptr<RelaxationResidual> residual = std::make_shared<RelaxationResidual>(1);
    ElasticPass<IncompressibleLaw, 1> elastic;
    RelaxPass<IncompressibleLaw, 1> relax;

    explicit Relaxing(const RodSpec& spec, RelaxationContacts contacts = {})
        : group(spec, 0, 0, ""), state(static_cast<std::size_t>(group.slots())), load(state.size()),
          elastic(ends_of(group)), relax(group, contacts, residual) {
        group.start_state(0, state);
        relax.expect(1);
    }
    /// A kick under a force on a node and a couple on an element, N and N m.
    void kick(std::size_t node, const Vec3d& force, std::size_t of = 0, const Vec3d& couple = {0, 0, 0}) {
        const RodTile<1> tile = tile_of(group, state);
        elastic.run(tile, load.data(), step);
        if (relax_notes) NoteForcesPass<1>().run(tile, load.data(), step);
        push(node, force, of, couple);
        relax.run(tile, load.data(), step);
    }
    void push(std::size_t node, const Vec3d& force, std::size_t of, const Vec3d& couple) {
        load[node].force += broadcast<1>(force);
        load[of].couple += broadcast<1>(couple);
        if (group.closed()) FoldRingPass<1>().run(tile_of(group, state), load.data(), step);
    }
    Vec3d velocity(std::size_t i) const { return lane(state[i].velocity, 0); }
    Vec3d spin(std::size_t i) const { return lane(state[i].spin, 0); }
    bool relax_notes = false;
};

/// At rest, K of (65) is the tangent stiffness but for the rod's own small share and for the square of the turn per
/// cell, so one correction leaves little of a small load.
class RelaxationOf : public testing::TestWithParam<std::string> {
public:
    static RodSpec rod() {
        RodSpec spec = test::clamped_unit_rod(12, 0.02);
        const std::string& kind = GetParam();
        if (kind == "curved") spec.shape.rest_curvature = {1.5, 0.7, 0.4};
        if (kind == "gregory") spec.shape.end_weights = EndWeights::gregory;
        if (kind == "tapered") spec.section.taper = 0.4;
        if (kind == "two_clamps") spec.end = EndKind::clamped;
        if (kind == "ring") {
            spec.shape.elements = 40;
            spec.shape.closed = true;
            spec.start = EndKind::free;
            spec.shape.rest_curvature = {2 * std::numbers::pi, 0, 0};
            spec.hold.nodes = {0};
            spec.hold.elements = {0};
        }
        return spec;
    }
};

TEST_P(RelaxationOf, CorrectionsAreThoseOfTheTangentStiffness) {
    Relaxing rod(RelaxationOf::rod());
    const bool ring = rod.group.closed();
    const double size = 1e-7 * rod.group.element[0].bending.x;
    const Vec3d force = size * Vec3d{0.3, -0.2, 0.4}, couple = size * Vec3d{0.2, 0.1, -0.3};
    rod.kick(7, force, 4, couple);
    RodTile<1> tile = tile_of(rod.group, rod.state);
    DriftPass<CircularGyration, 1>().run(tile, rod.load.data(), step);
    if (ring) CloseRingPass<1>().run(tile, rod.load.data(), step);
    rod.elastic.run(tile, rod.load.data(), step);
    rod.push(7, force, 4, couple);
    double left = 0;
    const auto& held = rod.group.spec();
    for (std::size_t i = 1; i + 1 < rod.load.size(); ++i) left = std::max(left, norm(lane(rod.load[i].force, 0)));
    if (!ring && held.end == EndKind::free) left = std::max(left, norm(lane(rod.load.back().force, 0)));
    for (std::size_t i = ring ? 1 : 0; i + 1 < rod.load.size(); ++i)
        left = std::max(left, norm(lane(rod.load[i].couple, 0)));
    std::printf("relaxation: %s rod, %.2e of the load is left\n", GetParam().c_str(), left / size);
    EXPECT_LT(left, 0.02 * size);
}

INSTANTIATE_TEST_SUITE_P(Rods, RelaxationOf,
                         testing::Values("straight", "gregory", "curved", "tapered", "two_clamps", "ring"),
                         [](const auto& kind) { return kind.param; });

TEST(Relaxation, HeldNodesAndElementsStay) {
    RodSpec spec = test::clamped_unit_rod(10, 0.02);
    spec.start = EndKind::clamped_frozen;
    spec.end = EndKind::pinned;
    spec.hold.nodes = {4};
    spec.hold.directions = "xz";
    spec.hold.elements = {6};
    spec.hold.axes = "y";
    Relaxing rod(spec);
    rod.kick(5, 1e-6 * Vec3d{1, 2, 3}, 6, 1e-8 * Vec3d{1, 2, 3});
    const Vec3d none{0, 0, 0};
    EXPECT_EQ(norm(rod.velocity(0) - none), 0);
    EXPECT_EQ(norm(rod.velocity(10) - none), 0);
    EXPECT_EQ(norm(rod.spin(0) - none), 0);
    EXPECT_EQ(rod.velocity(4).x, 0);
    EXPECT_EQ(rod.velocity(4).z, 0);
    EXPECT_NE(rod.velocity(4).y, 0);
    const Vec3d turning = transpose_times(frame(rod.state[6]), rod.spin(6));
    EXPECT_LT(std::abs(turning.y), 1e-15 * norm(turning));
    EXPECT_GT(norm(turning), 0);
    EXPECT_GT(norm(rod.velocity(5)), 0);
}

TEST(Relaxation, AFreeRodIsPushedAsAWhole) {
    RodSpec spec = test::clamped_unit_rod(8, 0.02);
    spec.start = EndKind::free;
    Relaxing rod(spec);
    const RodTile<1> tile = tile_of(rod.group, rod.state);
    rod.elastic.run(tile, rod.load.data(), step);
    for (std::size_t i = 0; i < rod.load.size(); ++i)
        rod.load[i].force += broadcast<1>(1e-12 * rod.group.node_length[i] * Vec3d{1, 2, 0});
    rod.relax.run(tile, rod.load.data(), step);
    for (std::size_t i = 0; i < rod.load.size(); ++i)
        EXPECT_LT(norm(rod.velocity(i) - rod.velocity(0)), 1e-9 * norm(rod.velocity(0))) << "node " << i;
    EXPECT_NEAR(rod.velocity(0).y / rod.velocity(0).x, 2, 1e-9);
}

/// A ring's first node is like any other, its last no node of its own.
TEST(Relaxation, RingsHaveNoBeginning) {
    RodSpec spec = test::clamped_unit_rod(16, 0.02);
    spec.start = EndKind::free;
    spec.shape.closed = true;
    spec.shape.rest_curvature = {2 * std::numbers::pi, 0, 0};
    const auto answer = [&](int pushed) { // at nodes and elements after the one that is pushed, in its frame
        Relaxing rod(spec, {1e-6, 1e-9, 1});
        rod.relax_notes = true;
        const Mat3d q = frame(nth(rod.state, pushed));
        rod.kick(static_cast<std::size_t>(pushed), transpose_times(q, Vec3d{1e-9, 2e-9, 3e-9}),
                 static_cast<std::size_t>(pushed), {1e-11, 2e-11, 3e-11});
        std::vector<Vec3d> rates;
        for (std::size_t i = 0; i < 16; ++i) {
            const auto k = (static_cast<std::size_t>(pushed) + i) % 16;
            rates.push_back(q * rod.velocity(k));
            rates.push_back(rod.spin(k));
        }
        return rates;
    };
    const auto first = answer(0);
    for (const int pushed : {1, 7, 14, 15}) {
        const auto other = answer(pushed);
        for (std::size_t i = 0; i < first.size(); ++i)
            EXPECT_LT(norm(other[i] - first[i]), 1e-9 * norm(first[i % 2])) << pushed << ", " << i;
    }
    RodSpec held = spec;
    held.hold.nodes = {-1};
    held.hold.elements = {-1};
    Relaxing rod(held);
    rod.kick(0, {1e-9, 2e-9, 3e-9});
    EXPECT_EQ(norm(rod.velocity(15)), 0);
    EXPECT_EQ(norm(rod.spin(15)), 0);
    EXPECT_GT(norm(rod.velocity(0)), 0);
}

TEST(Relaxation, RatesAgainstForcesAreForgotten) {
    const auto after = [](double sign) {
        Relaxing rod(test::clamped_unit_rod(8, 0.02));
        for (Slot<1>& s : rod.state) s.velocity = broadcast<1>(Vec3d{sign * 1e-9, 0, 0});
        rod.state[0].velocity = broadcast<1>(Vec3d{0, 0, 0});
        rod.kick(8, {1e-12, 0, 0});
        return rod.velocity(8).x;
    };
    const double from_rest = after(0);
    EXPECT_GT(from_rest, 0);
    EXPECT_EQ(after(-1), from_rest);
    EXPECT_NEAR(after(1), from_rest + 0.9e-9, 1e-20);
}

TEST(Relaxation, NoStepTurnsOrMovesTooFar) {
    Relaxing rod(test::clamped_unit_rod(20, 0.005)), touched(test::clamped_unit_rod(20, 0.005), {1e-6, 0, 1e-4});
    touched.relax_notes = true;
    const double most = std::min(0.1, 2 * 0.005 * 20);
    for (Relaxing* one : {&rod, &touched}) {
        one->kick(20, {1, 0, 0}); // 1e9 times what it can bear
        double turn = 0, apart = 0, move = 0;
        for (std::size_t i = 0; i <= 20; ++i) {
            turn = std::max(turn, norm(one->spin(i)));
            move = std::max(move, norm(one->velocity(i)));
            if (i > 0) apart = std::max(apart, 20 * norm(one->velocity(i) - one->velocity(i - 1)));
        }
        EXPECT_LE(std::max(turn, apart), most * (1 + 1e-12));
        if (one == &touched) {
            EXPECT_NEAR(move, 1e-4, 1e-12);
        }
        EXPECT_GT(one->residual->largest(), 1);
    }
}

TEST(Relaxation, RodsThatBounceAreSlowedDown) {
    Relaxing rod(test::clamped_unit_rod(20, 0.005), {1e-6, 0, 1e-4});
    rod.relax_notes = true;
    double reach = 1;
    const auto move = [&](double sign) {
        for (Slot<1>& s : rod.state)
            s.position = lane(s.position, 0).z * broadcast<1>(Vec3d{0, 0, 1}); // as at the start
        rod.kick(20, {sign, 0, 0});
        double move = 0;
        for (std::size_t i = 0; i <= 20; ++i) move = std::max(move, norm(rod.velocity(i)));
        return move;
    };
    EXPECT_NEAR(move(1), 1e-4 * reach, 1e-13);
    for (const double sign : {-1, 1, -1}) EXPECT_NEAR(move(sign), 1e-4 * (reach *= 0.5), 1e-13);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(move(-1), 1e-4 * (reach *= 1.05), 1e-13);
    std::vector<double> memory;
    rod.relax.append_memory(tile_of(rod.group, rod.state), 0, memory);
    EXPECT_NEAR(memory.at(0), reach, 1e-12); // in checkpoints
    Relaxing untouched(test::clamped_unit_rod(20, 0.005));
    memory.clear();
    untouched.relax.append_memory(tile_of(untouched.group, untouched.state), 0, memory);
    EXPECT_TRUE(memory.empty());
}

TEST(Relaxation, RodsOfNoNumbersHaveNotSettled) {
    for (const double bad : {std::nan(""), HUGE_VAL}) {
        Relaxing rod(test::clamped_unit_rod(8, 0.02));
        rod.kick(3, {bad, 0, 0});
        EXPECT_EQ(rod.residual->largest(), HUGE_VAL);
    }
}

TEST(Relaxation, ResidualIsTheLargestOfAllTilesAndOfNoNumbers) {
    RelaxationResidual residual(2);
    EXPECT_EQ(residual.largest(), 0);
    residual.expect(0, 1);
    residual.expect(1, 2);
    EXPECT_EQ(residual.largest(), HUGE_VAL);
    residual.set(0, 0, 1);
    residual.set(1, 0, 3);
    residual.set(1, 1, 2);
    EXPECT_EQ(residual.largest(), 3);
    residual.set(1, 0, std::nan(""));
    EXPECT_EQ(residual.largest(), HUGE_VAL);
}

} // namespace
} // namespace skein
