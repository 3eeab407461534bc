// Loads of published codes against their formulae, written out plainly; eight lanes against one.
#include "loads/load_list.hpp"
#include "loads/load_pass.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;
using State = std::vector<Slot<1>>;

Step step_at(double time) { return {.index = 1, .dt = 1, .drift = 1, .time = time, .slot = 0}; }

/// What a pass does to W rods side by side, given as W states.
template <int W> struct Tile {
    std::vector<Slot<W>> slot;
    std::vector<SlotLoad<W>> load;

    Tile(const RodGroup& group, const std::vector<State>& states)
        : slot(states[0].size()), load(states[0].size(), SlotLoad<W>{}) {
        for (std::size_t k = 0; k < slot.size(); ++k)
            for (int i = 0; i < W; ++i) {
                const Slot<1>& s = nth(states, i)[k];
                set_lane(slot[k].position, i, lane(s.position, 0));
                set_lane(slot[k].velocity, i, lane(s.velocity, 0));
                set_lane(slot[k].director, i, lane(s.director, 0));
                set_lane(slot[k].spin, i, lane(s.spin, 0));
            }
        tile = {slot.data(), group.element.data(), group.voronoi.data(), &group, group.elements(), 0, {}, W};
    }
    Tile& run(TilePass<W>& pass, double time) {
        const Step step = step_at(time);
        pass.bind(tile);
        pass.prepare(std::span(&step, 1));
        pass.run(tile, load.data(), step);
        return *this;
    }
    RodTile<W> tile;
};

Tile<1> apply(const Load& l, const RodGroup& group, const State& state, double time) {
    Tile<1> tile(group, {state});
    tile.run(*make_pass<1>(l, group), time);
    return tile;
}
Vec3d force(const Tile<1>& t, std::size_t i) { return lane(t.load[i].force, 0); }
Vec3d couple(const Tile<1>& t, std::size_t k) { return lane(t.load[k].couple, 0); }

void expect_near(const Vec3d& a, const Vec3d& b, double tolerance) {
    EXPECT_LE(norm(a - b), tolerance) << a.x << " " << a.y << " " << a.z;
}
bool same(const Vec3d& a, const Vec3d& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/// Rods of one length and section that a test tells apart by eye.
RodGroup even_group(long n) { return RodGroup(test::simple_rod(n), 0, 0, ""); }
RodGroup crooked_group(long n) { return RodGroup(test::crooked_rod(n), 0, 0, ""); }

TEST(SinusoidalEndForces, PullThenTurn) {
    const RodGroup group = even_group(5);
    const State state = test::shaken_state(group, 0.01, 0.3, 1);
    const SinusoidalEndForce load{.start = 2, .end = -3, .normal = {0, 1, 0}, .tangent = {0, 0, 1}, .hold = 0.5};
    const Vec3d roll{1, 0, 0}; // y x z
    for (const double t : {0.0, 0.49, 0.5, 0.7, 1.5, 2.5, 4.3}) {
        const Tile<1> out = apply(load, group, state, t);
        const double p = 0.5 * pi * (t - 0.5);
        const Vec3d u = t < 0.5 ? Vec3d{0, -2, 0} : std::cos(p) * roll + Vec3d{0, std::sin(p), 0};
        expect_near(force(out, 0), 2.0 * u, 1e-15);
        expect_near(force(out, 5), -3.0 * u, 1e-15);
        for (std::size_t i = 1; i < 5; ++i) expect_near(force(out, i), {0, 0, 0}, 0);
    }
    // turned by a quarter of the period: d/dt u = (2 pi/T) u(t + T/4)
    const double h = 1e-5;
    const Vec3d rate = (1 / (2 * h)) * (load.at(1.1 + h) - load.at(1.1 - h));
    expect_near(rate, (2 * pi / 4) * load.at(1.1 + 1), 1e-9);
}

TEST(Guide, PullsTheFirstNodeToItsPlaceBesideTheMiddle) {
    const RodGroup group = crooked_group(7);
    const State state = test::shaken_state(group, 0.02, 0.4, 1);
    Guide guide{.stiffness = 5, .along = "yz", .place = {"1", "0.1 * cos(3 * t)", "-0.2"}};
    guide.use({.duration = 1});
    Vec3d middle{0, 0, 0};
    for (const Slot<1>& slot : state) middle += (1.0 / 8) * lane(slot.position, 0);
    for (const double t : {0.0, 0.4}) {
        const Tile<1> out = apply(guide, group, state, t);
        const Vec3d away = lane(state[0].position, 0) - middle - Vec3d{1, 0.1 * std::cos(3 * t), -0.2};
        expect_near(force(out, 0), {0, -5 * away.y, -5 * away.z}, 1e-14);
        for (std::size_t i = 1; i < 8; ++i) expect_near(force(out, i), {0, 0, 0}, 0);
    }
    EXPECT_EQ(guide.largest_stiffness(group).value, 5 / group.node_mass[0]);
}

TEST(SlenderBodyDrag, IsThePublishedFormula) {
    const RodGroup group = crooked_group(7);
    const State state = test::shaken_state(group, 0.02, 0.4, 1);
    const Tile<1> out = apply(SlenderBodyDrag{.viscosity = 0.3}, group, state, 0);
    const auto x = [&](std::size_t i) { return lane(state[i].position, 0); };
    const auto v = [&](std::size_t i) { return lane(state[i].velocity, 0); };
    double total = 0;
    for (std::size_t k = 0; k < 7; ++k) total += norm(x(k + 1) - x(k));
    std::vector<Vec3d> expected(8, Vec3d{0, 0, 0});
    for (std::size_t k = 0; k < 7; ++k) {
        const double l = norm(x(k + 1) - x(k)), r = std::sqrt(group.element[k].volume / (pi * l));
        const Vec3d t = (1 / l) * (x(k + 1) - x(k));
        const double m0 = group.node_mass[k], m1 = group.node_mass[k + 1];
        const Vec3d mean = (1 / (m0 + m1)) * (m0 * v(k) + m1 * v(k + 1));
        const Vec3d f = (-4 * pi * 0.3 / std::log(total / r) * l) * (mean - (0.5 * dot(t, mean)) * t);
        expected[k] += 0.5 * f;
        expected[k + 1] += 0.5 * f;
    }
    for (std::size_t i = 0; i < 8; ++i) expect_near(force(out, i), expected[i], 1e-14);
}

// A straight rod drags half as much along itself as across, and with this load alone slows down as exp(-nu t), at first
// order.
TEST(SlenderBodyDrag, SlowsAStraightRodExponentiallyAtFirstOrder) {
    const RodGroup group = even_group(10);
    const double mu = 0.3, length = 1, radius = 0.02, mass = 1000 * pi * radius * radius * length;
    for (const auto& [direction, factor] : {std::pair{Vec3d{1, 0, 0}, 1.0}, std::pair{Vec3d{0, 0, 1}, 0.5}}) {
        const double rate = factor * 4 * pi * mu * length / std::log(length / radius) / mass, duration = 1 / rate;
        double before = 0;
        for (const int steps : {20, 40, 80, 160}) {
            State state(11);
            group.start_state(0, state);
            for (auto& s : state) set_lane(s.velocity, 0, direction);
            for (int i = 0; i < steps; ++i) {
                const Tile<1> out = apply(SlenderBodyDrag{.viscosity = mu}, group, state, 0);
                for (std::size_t k = 0; k < 11; ++k)
                    set_lane(state[k].velocity, 0,
                             lane(state[k].velocity, 0) + (duration / steps / group.node_mass[k]) * force(out, k));
            }
            for (const auto& s : state)
                expect_near(lane(s.velocity, 0), dot(lane(state[0].velocity, 0), direction) * direction, 1e-13);
            const double error = dot(lane(state[5].velocity, 0), direction) - std::exp(-1.0);
            if (steps > 20) {
                EXPECT_NEAR(std::log2(before / error), 1, 0.05) << error;
            }
            before = error;
        }
        EXPECT_NEAR(before, -std::exp(-1.0) / 2 / 160, 2e-5); // (1 - 1/N)^N = exp(-1) (1 - 1/(2N) ..)
    }
}

TEST(BSpline, IsScipysClampedCubic) {
    // scipy.interpolate.BSpline on the published knots
    const std::vector<double> five{0, 3.4e-3, 3.3e-3, 5.7e-3, 2.8e-3, 0}, four{1, -2, 4, 0.5};
    const std::pair<double, double> six_values[] = {{0, 0},           {0.1, 0.002233125},     {1.0 / 3, 0.003725},
                                                    {0.5, 0.0044125}, {0.77, 0.003941709525}, {1, 0}};
    for (const auto& [s, value] : six_values) EXPECT_NEAR(cubic_bspline(five, s), value, 1e-16) << s;
    const std::pair<double, double> four_values[] = {{0, 1}, {0.25, 0.1484375}, {0.9, 1.2835}, {1, 0.5}};
    for (const auto& [s, value] : four_values) EXPECT_NEAR(cubic_bspline(four, s), value, 1e-15) << s;
}

TEST(MuscleTorques, AreThePublishedFormula) {
    const RodGroup group = crooked_group(6);
    const State state = test::shaken_state(group, 0.01, 0.3, 1);
    const double t = 0.7;
    for (const bool spline : {false, true}) {
        MuscleTorques load{.period = 2, .wave_number = 5, .phase = 0.4, .direction = {0, 0.6, 0.8}, .ramp = {2.8}};
        if (spline) load.coefficients = {0, 3, 1, 2, 0.5};
        else load.table = {1, 2, 3, 4, 5, 6};
        const Tile<1> out = apply(load, group, state, t);
        double length = 0, sum = 0;
        for (const auto& e : group.element) length += e.rest_length;
        std::vector<double> a(6);
        for (std::size_t i = 0; i < 6; ++i) {
            sum += group.element[i].rest_length;
            const double s = sum / length;
            a[i] = 0.25 * (spline ? cubic_bspline(load.coefficients, s) : load.table[i]) *
                   std::sin(2 * pi / 2 * t - 5 * s + 0.4);
        }
        Vec3d total{0, 0, 0};
        for (std::size_t e = 0; e < 6; ++e) {
            const Mat3d q = frame(state[e]);
            Vec3d expected{0, 0, 0};
            if (e >= 1) expected += a[5 - e] * (q * load.direction);
            if (e <= 4) expected -= a[5 - (e + 1)] * (q * load.direction);
            expect_near(couple(out, e), expected, 1e-14);
            total += transpose_times(q, couple(out, e));
        }
        expect_near(total, {0, 0, 0}, 1e-14);
    }
}

// On an even rod it is the muscle wave of the other load, seen from the other end.
TEST(MuscleTorques, MirrorTheMuscleWave) {
    const RodGroup group = even_group(8);
    const State state = test::shaken_state(group, 0.01, 0.3, 1);
    const double k = 7, phase = 0.3;
    const Tile<1> one =
        apply(MuscleTorques{.table = std::vector<double>(8, 0.2), .period = 1.5, .wave_number = k, .phase = phase},
              group, state, 0.9);
    const Tile<1> other = apply(
        MuscleWave{.amplitude = 0.2, .period = 1.5, .wavelength = -2 * pi / k, .phase = phase - k}, group, state, 0.9);
    for (std::size_t e = 0; e < 8; ++e) expect_near(couple(one, e), couple(other, e), 1e-14);
}

TEST(MagneticField, RisesAndFallsByItsRamp) {
    const MagneticField field{.constant = {0, 0, 4}, .ramp = {0.5, 1}, .until = 3};
    for (const auto& [t, share] :
         {std::pair{0.5, 0.0}, {1.0, 0.0}, {1.25, 0.5}, {1.5, 1.0}, {3.0, 1.0}, {3.125, 0.75}, {3.5, 0.0}, {9.0, 0.0}})
        expect_near(field.at(t), {0, 0, 4 * share}, 1e-15);
    const MagneticField cut_short{
        .constant = {0, 0, 1}, .ramp = {2, 0}, .until = 1}; // as published: from half up, down from 1
    EXPECT_DOUBLE_EQ(cut_short.at(1).z, 0.5);
    EXPECT_DOUBLE_EQ(cut_short.at(1.5).z, 0.75);
    const MagneticField sudden{.constant = {0, 0, 1}, .ramp = {0, 1}, .until = 2};
    EXPECT_EQ(sudden.at(0.99).z, 0);
    EXPECT_EQ(sudden.at(1.5).z, 1);
    EXPECT_EQ(sudden.at(2.01).z, 0);
    const MagneticField plain{.constant = {0, 0, 1}, .ramp = {0.3}};
    for (const double t : {0.0, 0.1, 0.3, 5.0}) EXPECT_EQ(plain.at(t).z, ramp_at(t, 0.3));
}

TEST(PublishedLoads, EightLanesHaveTheBitsOfOne) {
    RodSpec spec = test::crooked_rod(9);
    spec.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 5e3, .direction = {1, 2, 2}};
    const RodGroup group(spec, 0, 0, "");
    std::vector<State> states;
    for (unsigned i = 0; i < 8; ++i) states.push_back(test::shaken_state(group, 0.02, 0.4, 1, i + 1));
    const auto compare = [&]<class L>(const L& load) {
        LoadPass<L, 8> wide_pass(load, group);
        LoadPass<L, 1> narrow_pass(load, group);
        Tile<8> wide(group, states);
        wide.run(wide_pass, 0.37);
        for (int i = 0; i < 8; ++i) {
            Tile<1> narrow(group, {nth(states, i)});
            narrow.run(narrow_pass, 0.37);
            for (std::size_t k = 0; k < narrow.slot.size(); ++k) {
                EXPECT_TRUE(same(lane(wide.load[k].force, i), lane(narrow.load[k].force, 0))) << L::kind;
                EXPECT_TRUE(same(lane(wide.load[k].couple, i), lane(narrow.load[k].couple, 0))) << L::kind;
                EXPECT_TRUE(same(lane(wide.slot[k].velocity, i), lane(narrow.slot[k].velocity, 0))) << L::kind;
                EXPECT_TRUE(same(lane(wide.slot[k].spin, i), lane(narrow.slot[k].spin, 0))) << L::kind;
            }
        }
    };
    compare(SinusoidalEndForce{.start = 2, .end = 1});
    compare(SlenderBodyDrag{.viscosity = 0.1});
    Guide guide{.stiffness = 5, .along = "xy", .place = {"t", "1", "0"}};
    guide.use({.duration = 1});
    compare(guide);
    compare(MuscleTorques{.coefficients = {0, 1, 2, 0}, .period = 1, .wave_number = 6});
    compare(MagneticField{.constant = {0, 0, 0.1}, .ramp = {2, 0.1}, .until = 0.3});
}

} // namespace
} // namespace skein
