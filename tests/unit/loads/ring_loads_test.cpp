// Loads and damping on rings: no vertex, node or element is first or last.
#include "loads/damping.hpp"
#include "loads/load_list.hpp"
#include "loads/load_pass.hpp"
#include "mechanics/drift.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;
constexpr std::size_t n = 9;
using State = std::vector<Slot<1>>;

RodSpec ring_spec() {
    RodSpec spec = test::simple_rod(n);
    spec.shape.closed = true;
    return spec;
}

State closed(State state) {
    state[n].position = state[0].position;
    state[n].velocity = state[0].velocity;
    return state;
}

/// The same ring, numbered from another node on.
State renumbered(const State& state, std::size_t from) {
    State other = state;
    for (std::size_t k = 0; k < n; ++k) other[k] = state[(k + from) % n];
    return closed(other);
}

/// What a load adds at time t; forces on slot n handed to node 0.
std::vector<SlotLoad<1>> apply(const Load& load, const RodGroup& group, State state, double t) {
    std::vector<SlotLoad<1>> out(n + 1, SlotLoad<1>{});
    const RodTile<1> tile = test::tile_of(group, state);
    const auto pass = make_pass<1>(load, group);
    const Step step{.index = 1, .dt = 1, .drift = 1, .time = t, .slot = 0};
    pass->prepare(std::span(&step, 1));
    pass->run(tile, out.data(), step);
    FoldRingPass<1>().run(tile, out.data(), step);
    return out;
}

void expect_near(const Vec3d& a, const Vec3d& b, double tolerance) {
    EXPECT_LE(norm(a - b), tolerance) << a.x << " " << a.y << " " << a.z;
}

TEST(RingLoads, DoNotKnowWhereTheNumbersBegin) {
    const RodGroup group(ring_spec(), 0, 0, "");
    const State state = closed(test::shaken_state(group, 0.005, 0.3, 1));
    for (const Load& load : {Load(SlenderBodyDrag{.viscosity = 0.3}), Load(Gravity{}),
                             Load(UniformForce{.force = {1, 2, 3}}), Load(UniformCouple{.couple = {1, 2, 3}})}) {
        const auto first = apply(load, group, state, 1);
        for (const std::size_t from : {std::size_t{1}, std::size_t{4}, n - 1}) {
            const auto other = apply(load, group, renumbered(state, from), 1);
            for (std::size_t k = 0; k < n; ++k) {
                expect_near(lane(other[k].force, 0), lane(first[(k + from) % n].force, 0), 1e-13);
                expect_near(lane(other[k].couple, 0), lane(first[(k + from) % n].couple, 0), 1e-13);
            }
        }
    }
}

// A ring that moves as one feels the drag of its whole length: across its plane 4 pi mu L/ln(L/r) v.
TEST(RingLoads, DragOfARingIsThatOfItsLength) {
    const RodGroup group(ring_spec(), 0, 0, "");
    State state(n + 1);
    group.start_state(0, state);
    double length = 0;
    for (std::size_t k = 0; k < n; ++k) length += norm(lane(state[k + 1].position, 0) - lane(state[k].position, 0));
    const Vec3d across = frame(state[0]).d1;
    for (auto& s : state) set_lane(s.velocity, 0, across);
    const auto load = apply(SlenderBodyDrag{.viscosity = 0.3}, group, state, 0);
    Vec3d total{0, 0, 0};
    for (std::size_t k = 0; k < n; ++k) total += lane(load[k].force, 0);
    const double radius = std::sqrt(group.element[0].volume / (pi * length / n));
    expect_near(total, (-4 * pi * 0.3 * length / std::log(length / radius)) * across, 1e-12);
    EXPECT_NEAR(SlenderBodyDrag{.viscosity = 0.3}.largest_rate(group).value,
                4 * pi * 0.3 / std::log(1 / 0.02) / (1000 * pi * 0.02 * 0.02), 1e-10);
}

TEST(RingLoads, MusclesActAtTheClosingVertexToo) {
    const RodGroup group(ring_spec(), 0, 0, "");
    const State state = closed(test::shaken_state(group, 0.005, 0.3, 1));
    const double t = 0.4, k = 2 * pi * 3; // three waves around
    MuscleWave wave{.amplitude = 0.3, .period = 2, .wavelength = 1.0 / 3, .phase = 0.4, .direction = {0.6, 0, 0.8}};
    for (std::size_t j = 1; j <= n; ++j) wave.profile.push_back(1 + 0.1 * static_cast<double>(j));
    const MuscleTorques torques{
        .table = wave.profile, .period = 2, .wave_number = k, .phase = 0.4, .direction = wave.direction};
    const auto of_wave = [&](std::size_t vertex) { // vertex n is vertex 0
        const std::size_t j = vertex == 0 ? n : vertex;
        return 0.3 * wave.profile[j - 1] * std::sin(pi * t - k * static_cast<double>(j) / n + 0.4);
    };
    const auto of_torques = [&](std::size_t vertex) {
        const std::size_t i = n - 1 - vertex;
        return torques.table[i] * std::sin(pi * t - k * static_cast<double>(i + 1) / n + 0.4);
    };
    const auto check = [&](const Load& load, const auto& amplitude) {
        const auto out = apply(load, group, state, t);
        for (std::size_t e = 0; e < n; ++e)
            expect_near(lane(out[e].couple, 0),
                        lane(state[e].director, 0) * ((amplitude(e) - amplitude((e + 1) % n)) * wave.direction), 1e-14);
    };
    check(wave, of_wave);
    check(torques, of_torques);
}

TEST(RingLoads, LegacyDampingGivesEveryElementTheMassOfItsNode) {
    RodSpec spec = ring_spec();
    for (std::size_t k = 0; k < n; ++k) spec.section.profile.push_back(1 + 0.05 * static_cast<double>(k));
    const RodGroup group(spec, 0, 0, "");
    const Damping legacy{.kind = DampingKind::legacy, .rate = 0.5};
    const DampingRates rates = damping_rates(group, {&legacy, 1});
    for (std::size_t k = 0; k < n; ++k) {
        EXPECT_DOUBLE_EQ(rates.node[k], 0.5);
        EXPECT_DOUBLE_EQ(rates.element_stretched[k].x, 0.5 * group.node_mass[k] / group.element[k].inertia.x);
    }
}

TEST(RingLoads, TheLastNodeThatIsHeldIsNotTheFirst) {
    RodSpec spec = ring_spec();
    spec.hold = {.nodes = {-1}};
    spec.shape.velocity = {1, 2, 3};
    const RodGroup group(spec, 0, 0, "");
    State state(n + 1);
    group.start_state(0, state);
    expect_near(lane(state[n - 1].velocity, 0), {0, 0, 0}, 0);
    for (const std::size_t i : {std::size_t{0}, n - 2, n}) expect_near(lane(state[i].velocity, 0), {1, 2, 3}, 0);
}

} // namespace
} // namespace skein
