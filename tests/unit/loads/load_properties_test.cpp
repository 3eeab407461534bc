// What must hold of every load, over tests/support/load_examples.hpp: it turns with its scene, internal ones carry no
// momentum, forces are minus the gradient of a potential where there is one, friction feels what presses, what reads
// velocities says its rate. And of every law with an energy: its forces are internal, and rest is rest wherever a rod
// lies.
#include "mechanics/drift.hpp"
#include "mechanics/elastic.hpp"
#include "support/load_examples.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

namespace skein {
namespace {

using test::LoadExample, test::State, test::Turn;

RodSpec magnetised(RodSpec spec) {
    spec.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 5e3, .direction = {1, 2, 2}};
    return spec;
}
RodSpec ring_spec() {
    RodSpec spec = test::simple_rod(9);
    spec.shape.closed = true;
    return spec;
}
State closed(State state) {
    state.back().position = state.front().position;
    state.back().velocity = state.front().velocity;
    return state;
}

std::vector<SlotLoad<1>> nothing_yet(const State& state) {
    return std::vector<SlotLoad<1>>(state.size(), SlotLoad<1>{});
}

/// Adds what a load does to `sum`.
void add(const Load& load, const RodGroup& group, State state, double time, std::vector<SlotLoad<1>>& sum) {
    const RodTile<1> tile = test::tile_of(group, state);
    const auto pass = make_pass<1>(load, group);
    const Step step{.index = 1, .dt = 1, .drift = 1, .time = time, .slot = 0};
    pass->bind(tile);
    pass->prepare(std::span(&step, 1));
    pass->run(tile, sum.data(), step);
    if (group.closed()) FoldRingPass<1>().run(tile, sum.data(), step);
}
std::vector<SlotLoad<1>> apply(const Load& load, const RodGroup& group, const State& state, double time) {
    auto sum = nothing_yet(state);
    add(load, group, state, time, sum);
    return sum;
}
Vec3d force(const std::vector<SlotLoad<1>>& load, std::size_t i) { return lane(load[i].force, 0); }
Vec3d couple(const std::vector<SlotLoad<1>>& load, std::size_t k) { return lane(load[k].couple, 0); }

/// Largest force and couple.
double size_of(const std::vector<SlotLoad<1>>& load) {
    double most = 0;
    for (std::size_t i = 0; i < load.size(); ++i) most = std::max({most, norm(force(load, i)), norm(couple(load, i))});
    return most;
}

struct Net {
    Vec3d force{0, 0, 0}, moment{0, 0, 0}; ///< lab, about the origin
};
Net net(const RodGroup& group, const State& state, const std::vector<SlotLoad<1>>& load) {
    Net sum;
    const std::size_t n = group.element.size();
    for (std::size_t i = 0; i < (group.closed() ? n : n + 1); ++i) {
        sum.force += force(load, i);
        sum.moment += cross(lane(state[i].position, 0), force(load, i));
        if (i < n) sum.moment += transpose_times(lane(state[i].director, 0), couple(load, i));
    }
    return sum;
}

Turn some_turn() { return {rotation(Vec3d{0.7, -1.3, 2.1}), {0.3, -0.8, 1.1}}; }

TEST(EveryLoad, HasAnExample) {
    std::set<std::string_view> there;
    const auto examples = test::load_examples();
    for (const LoadExample& e : examples) there.insert(e.load.kind());
    for (const std::string_view kind : load_kinds())
        EXPECT_TRUE(there.contains(kind))
            << "give an example of the load " << kind << " in tests/support/load_examples.hpp";
}

TEST(EveryLoad, TurnsWithItsScene) {
    const Turn turn = some_turn();
    const RodSpec spec = magnetised(test::crooked_rod(7));
    const RodGroup group(spec, 0, 0, ""), turned_group(turn.rod(spec), 0, 0, "");
    for (unsigned seed = 1; seed <= 3; ++seed) {
        const State state = test::shaken_state(group, 0.02, 0.3, 1, seed), turned_state = turn.state(state);
        for (LoadExample& e : std::vector(test::load_examples())) {
            const auto here = apply(e.load, group, state, 0.7);
            e.turn(e.load, turn);
            const auto there = apply(e.load, turned_group, turned_state, 0.7);
            ASSERT_GT(size_of(here), 0) << e.name();
            for (std::size_t i = 0; i < here.size(); ++i) {
                EXPECT_LE(norm(turn.direction(force(here, i)) - force(there, i)), 1e-12 * size_of(here))
                    << e.name() << ", node " << i;
                EXPECT_LE(norm(couple(here, i) - couple(there, i)), 1e-12 * size_of(here))
                    << e.name() << ", element " << i;
            }
        }
    }
}

TEST(EveryLoad, ThatIsInternalCarriesNoMomentum) {
    for (const RodSpec& spec : {test::simple_rod(8), test::crooked_rod(9), ring_spec()}) {
        const RodGroup group(spec, 0, 0, "");
        for (unsigned seed = 1; seed <= 5; ++seed) {
            State state = test::shaken_state(group, 0.02, 0.5, 1, seed);
            if (group.closed()) state = closed(state);
            for (const LoadExample& e : test::load_examples()) {
                if (!e.internal) continue;
                const auto load = apply(e.load, group, state, 0.7);
                const Net sum = net(group, state, load);
                EXPECT_LE(norm(sum.force), 1e-14 * size_of(load)) << e.name();
                EXPECT_LE(norm(sum.moment), 1e-14 * size_of(load)) << e.name();
            }
        }
    }
}

TEST(EveryLoad, WithAPotentialIsItsGradient) {
    RodSpec spec = magnetised(test::crooked_rod(6));
    const RodGroup group(spec, 0, 0, "");
    const State state = test::shaken_state(group, 0.02, 0.3, 1);
    constexpr double h = 1e-4, time = 0.7;
    for (const LoadExample& e : test::load_examples()) {
        if (!e.potential) continue;
        const auto load = apply(e.load, group, state, time);
        const double size = size_of(load);
        const auto fall = [&](const auto& move) { // fourth-order difference, whose error is below that of round-off
            const auto energy = [&](double by) {
                State s = state;
                move(s, by);
                return e.potential(group, s, time);
            };
            return -(8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h);
        };
        for (std::size_t i = 0; i < state.size(); ++i)
            for (const Vec3d axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
                const double f =
                    fall([&](State& s, double by) { set_lane(s[i].position, 0, lane(s[i].position, 0) + by * axis); });
                EXPECT_NEAR(f, dot(axis, force(load, i)), 1e-8 * size) << e.name() << ", node " << i;
                if (i + 1 == state.size()) continue;
                const double c = fall([&](State& s, double by) {
                    set_lane(s[i].director, 0, rotation(by * axis) * lane(s[i].director, 0));
                });
                EXPECT_NEAR(c, dot(axis, couple(load, i)), 1e-8 * size) << e.name() << ", element " << i;
            }
    }
}

// On a plane without stiffness all that presses is borne: the sum of the forces along the normal is 0, whatever else
// acts.
TEST(EveryLoad, IsFeltByFriction) {
    const RodSpec spec = magnetised(test::simple_rod(8));
    const RodGroup group(spec, 0, 0, "");
    const State state = test::shaken_state(group, 0, 0, 0);
    PlaneFriction ground{.normal = {1, 0, 0}, .stiffness = 0, .tolerance = 1};
    ground.kinetic_sideways = 0.5;
    const Load heavy = Gravity{.acceleration = {-1e3, 0, 0}};
    double pressed = 0;
    for (const LoadExample& e : test::load_examples()) {
        if (e.load.acts_last()) continue;
        auto sum = apply(heavy, group, state, 0.7);
        const double weight = net(group, state, sum).force.x;
        add(e.load, group, state, 0.7, sum);
        pressed += std::abs(net(group, state, sum).force.x - weight);
        ASSERT_LT(net(group, state, sum).force.x, 0) << e.name();
        add(ground, group, state, 0.7, sum);
        EXPECT_NEAR(net(group, state, sum).force.x / weight, 0, 1e-14) << e.name();
    }
    EXPECT_GT(pressed, 1);
}

// What reads velocities takes energy at a rate that it says, or the limit of the step does not know of it.
TEST(EveryLoad, ThatReadsVelocitiesSaysItsRate) {
    const RodGroup group(magnetised(test::simple_rod(8)), 0, 0, "");
    const State rest = test::shaken_state(group, 0, 0, 0);
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (const LoadExample& e : test::load_examples()) {
        const auto still = apply(e.load, group, rest, 0.7);
        for (int wave = 0; wave < 9; ++wave) {
            State moving = rest;
            for (std::size_t i = 0; i < moving.size(); ++i)
                set_lane(moving[i].velocity, 0,
                         std::cos(std::numbers::pi * wave * static_cast<double>(i) / 8) *
                             Vec3d{normal(random), normal(random), normal(random)});
            const auto load = apply(e.load, group, moving, 0.7);
            double power = 0, twice_energy = 0;
            for (std::size_t i = 0; i < moving.size(); ++i) {
                const Vec3d v = lane(moving[i].velocity, 0);
                power -= dot(v, force(load, i) - force(still, i));
                twice_energy += group.node_mass[i] * dot(v, v);
            }
            EXPECT_GE(power, 0) << e.name() << " gives energy to what moves";
            EXPECT_LE(power / twice_energy, e.load.largest_rate(group).value) << e.name();
        }
    }
}

// What pushes back where it is approached is as stiff as it says, or the limit of the step does not know of it.
TEST(EveryLoad, ThatReadsPlacesSaysItsStiffness) {
    const RodGroup group(magnetised(test::simple_rod(8)), 0, 0, "");
    const State rest = test::shaken_state(group, 0, 0, 0);
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    constexpr double small = 1e-6;
    int stiff = 0;
    for (const LoadExample& e : test::load_examples()) {
        const double bound = e.load.largest_stiffness(group).value;
        stiff += bound > 0;
        for (int wave = 0; wave < 9; ++wave) {
            std::vector<Vec3d> by(rest.size());
            State there = rest, back = rest;
            for (std::size_t i = 0; i < rest.size(); ++i) {
                by[i] = std::cos(std::numbers::pi * wave * static_cast<double>(i) / 8) *
                        Vec3d{normal(random), normal(random), normal(random)};
                set_lane(there[i].position, 0, lane(rest[i].position, 0) + small * by[i]);
                set_lane(back[i].position, 0, lane(rest[i].position, 0) - small * by[i]);
            }
            const auto load = apply(e.load, group, there, 0.7), other = apply(e.load, group, back, 0.7);
            double work = 0, mass = 0, size = 0;
            for (std::size_t i = 0; i < rest.size(); ++i) {
                work -= dot(by[i], force(load, i) - force(other, i)) / (2 * small);
                mass += group.node_mass[i] * dot(by[i], by[i]);
                size = std::max(size, norm(force(load, i)));
            }
            EXPECT_LE(work / mass, bound + 1e-13 * size / (small * mass)) << e.name();
        }
    }
    EXPECT_GE(stiff, 2);
}

TEST(EveryLaw, IsInternalAndRestIsRestAnywhere) {
    const Turn turn = some_turn();
    for (const Law law : {Law::incompressible, Law::linear, Law::neo_hookean})
        for (RodSpec spec : {test::simple_rod(8), test::crooked_rod(9), ring_spec()}) {
            spec.material.law = law;
            const RodGroup group(spec, 0, 0, "");
            const auto inner = [&](State state) {
                auto load = nothing_yet(state);
                const RodTile<1> tile = test::tile_of(group, state);
                with_energy_law(law,
                                [&]<class L>(L) { ElasticPass<L, 1>(ends_of(group)).run(tile, load.data(), Step{}); });
                if (group.closed()) FoldRingPass<1>().run(tile, load.data(), Step{});
                return load;
            };
            State rest(static_cast<std::size_t>(group.slots()));
            group.start_state(0, rest);
            double stretch = 0;
            for (const auto& e : group.element) stretch = std::max(stretch, e.stiffness.z);
            EXPECT_LE(size_of(inner(turn.state(rest))), 1e-13 * stretch);
            for (unsigned seed = 1; seed <= 5; ++seed) {
                State state = test::shaken_state(group, 0.01, 0.3, 1, seed);
                if (group.closed()) state = closed(state);
                const auto load = inner(state);
                const Net sum = net(group, state, load);
                EXPECT_LE(norm(sum.force), 1e-14 * size_of(load));
                EXPECT_LE(norm(sum.moment), 1e-14 * size_of(load));
            }
        }
}

} // namespace
} // namespace skein
