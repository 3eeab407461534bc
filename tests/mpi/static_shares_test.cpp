// Loads and stiffness at rest that ranks share have the bits of one rank.
#include "physics/walls/wall_plan.hpp"
#include "studies/scene_family.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace skein {
namespace {

/// Two layers of crossed sticks that touch each other and a floor, and a ball on them.
const char* const heap = R"(
title = "heap"

[time]
duration = 1.0

[[rods]]
name = "lower"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 2e-3
shape = {length = 0.05, elements = 6}
placement = {kind = "lattice", counts = [1, 4, 1], spacing = [0.01, 0.01, 0.01], origin = [0.0, 0.0, 1.95e-3], tangent = [1, 0, 0]}

[[rods]]
name = "upper"
material = {density = 1000.0, youngs_modulus = 1e6}
section.radius = 2e-3
shape = {length = 0.05, elements = 9}
placement = {kind = "lattice", counts = [3, 1, 1], spacing = [0.013, 0.01, 0.01], origin = [0.01, -0.01, 5.85e-3], tangent = [0, 1, 0]}

[[bodies]]
name = "ball"
density = 800.0
spheres.radii = [4e-3]
placement.origin = [0.023, 0.015, 11.75e-3]

[[load]]
kind = "gravity"

[contact]
stiffness = 100.0
friction = "memory"
static_friction = 0.4

[[wall]]
name = "floor"
kind = "plane"
stiffness = 100.0
friction = "memory"
static_friction = 0.4
)";

/// A grid of joined rods: by springs of one joint, of two at a place, and to the world.
const char* const grid = R"(
title = "grid"

[time]
duration = 1.0

[[rods]]
name = "warp"
material = {density = 1000.0, youngs_modulus = 1e7}
section.radius = 2e-3
shape = {length = 0.1, elements = 5}
placement = {kind = "lattice", counts = [1, 5, 1], spacing = [0.1, 0.025, 0.1], tangent = [1, 0, 0]}

[[rods]]
name = "weft"
material = {density = 1000.0, youngs_modulus = 1e7}
section.radius = 2e-3
shape = {length = 0.1, elements = 4}
placement = {kind = "lattice", counts = [3, 1, 1], spacing = [0.05, 0.1, 0.1], tangent = [0, 1, 0]}

[[load]]
kind = "gravity"

[[joint]]
kind = "fixed"
between = ["warp", "weft"]
pairs = "listed"
first = [0, 1, 2, 3, 4]
second = [0, 0, 0, 0, 0]
at = [0.0, 0.0]
stiffness = 1e3
torsional_stiffness = 0.01

[[joint]]
kind = "spherical"
between = ["warp", "weft"]
pairs = "listed"
first = [0, 0, 4, 4]
second = [1, 2, 1, 2]
at = [1.0, 1.0]
stiffness = 1e3

[[joint]]
kind = "spherical"
between = ["weft", "world"]
at = [0.0]
stiffness = 1e3
)";

bool same(const std::vector<double>& a, const std::vector<double>& b) { return a == b; }

std::vector<double> numbers(const Unknown& x) { return {x.data(), x.data() + x.size()}; }

std::vector<double> numbers(const Stiffness& matrix) {
    std::vector<double> all(matrix.valuePtr(), matrix.valuePtr() + matrix.nonZeros());
    all.insert(all.end(), matrix.innerIndexPtr(), matrix.innerIndexPtr() + matrix.nonZeros());
    all.insert(all.end(), matrix.outerIndexPtr(), matrix.outerIndexPtr() + matrix.outerSize() + 1);
    return all;
}

void expect_same(const StaticSystem::Balance& own, const StaticSystem::Balance& shared) {
    EXPECT_TRUE(same(numbers(own.residual), numbers(shared.residual)));
    EXPECT_EQ(own.force_size, shared.force_size);
    EXPECT_EQ(own.couple_size, shared.couple_size);
    if (!own.stiffness) return;
    EXPECT_GT(own.stiffness->nonZeros(), 0);
    EXPECT_TRUE(same(numbers(*own.stiffness), numbers(*shared.stiffness)));
    EXPECT_EQ(own.asymmetry, shared.asymmetry);
}

/// The same motions, in no order, on both systems, with balances between.
void compare(const char* scene) {
    const Communicator comm = Communicator::world();
    const auto one = static_case({"scene.toml", scene, {}}, {}, 1);
    const auto* walls = one->plan.find<WallPlan>();
    const auto shared =
        make_static_system(one->plan, one->groups, one->rods, walls ? std::make_shared<Walls>(walls->walls) : nullptr,
                           *one->threads, &comm);
    shared->set_time(1);
    StaticSystem& alone = *one->system;
    StaticState state = start_of(alone, one->groups, one->rods);
    for (StaticSystem* system : {&alone, shared.get()}) system->set_reference(state);
    expect_same(alone.balance(state, true), shared->balance(state, true));
    for (const double way : {1e-5, -3e-5, 1e-4}) { // contacts come and go, so that patterns are found anew
        Unknown move(alone.unknowns());
        for (Eigen::Index u = 0; u < move.size(); ++u) move[u] = way * std::sin(1.0 + 7.0 * static_cast<double>(u));
        alone.correct(state, move, 1);
        expect_same(alone.balance(state, true), shared->balance(state, true));
        expect_same(alone.balance(state, false), shared->balance(state, false));
        for (StaticSystem* system : {&alone, shared.get()}) system->keep_springs(state);
    }
    expect_same(alone.sticking_balance(state).first, shared->sticking_balance(state).first);
    EXPECT_TRUE(same(numbers(alone.damping(state)), numbers(shared->damping(state))));
    expect_same(alone.balance(state, true), shared->balance(state, true));
    for (std::size_t i = 0; i < one->rods.size(); ++i)
        EXPECT_TRUE(same(alone.at_rest().wall_memory(i), shared->at_rest().wall_memory(i)));
}

TEST(StaticShares, BodiesThatTouchHaveTheBitsOfOneRank) {
    const auto one = static_case({"scene.toml", heap, {}}, {}, 1);
    StaticContactLoads loads;
    one->system->contacts()->evaluate(start_of(*one->system, one->groups, one->rods).slot, false, loads);
    EXPECT_GT(loads.contacts.size(), 12U); // each upper stick on four lower ones, and the ball
    compare(heap);
}
TEST(StaticShares, JoinedRodsHaveTheBitsOfOneRank) { compare(grid); }

} // namespace
} // namespace skein
