// The Laplacian filter of the rates: its modes, what it keeps, and that no rod of any shape and ends gains energy by
// it.
#include "loads/laplacian_filter.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;
using State = std::vector<Slot<1>>;

State filtered(const RodGroup& group, State state, long order, double rate, double h) {
    std::vector<SlotLoad<1>> load(state.size());
    LaplacianFilterPass<1>(group, order, rate, h).run(tile_of(group, state), load.data(), Step{});
    return state;
}

/// What is kept of a mode whose eigenvalue of F^p is mu.
double saved(double mu, double z) {
    const double s = 1 - std::exp(-z);
    return 1 - (s + 0.5 * s * s) * mu + 0.5 * s * s * mu * mu;
}

/// Kinetic products of two states' rates: of nodes and of elements.
struct Products {
    double nodes = 0, elements = 0;
};
Products product(const RodGroup& group, const State& a, const State& b) {
    Products sum;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum.nodes += group.node_mass[i] * dot(lane(a[i].velocity, 0), lane(b[i].velocity, 0));
        if (i + 1 < a.size())
            sum.elements += dot(lane(a[i].spin, 0), scale(group.element[i].inertia, lane(b[i].spin, 0)));
    }
    return sum;
}

/// Rods of every shape and kind of end; a ring has none.
std::vector<RodGroup> all_rods() {
    std::vector<RodSpec> specs{test::simple_rod(9), test::crooked_rod(8), test::crooked_rod(2)};
    RodSpec scaled = test::crooked_rod(7), profile = test::simple_rod(6), ring = test::simple_rod(9),
            rough = test::simple_rod(3);
    scaled.material.rotary_inertia_scale = 30;
    profile.section.profile = {1, 0.01, 1, 3, 0.2, 1};
    for (RodSpec* r : {&ring, &rough}) r->shape.closed = true;
    rough.section.profile = {1, 0.3, 2};
    RodSpec weighted = test::simple_rod(9);
    weighted.shape.end_weights = EndWeights::gregory;
    for (const RodSpec& spec : {scaled, profile, weighted}) specs.push_back(spec);
    std::vector<RodGroup> rods;
    for (const RodSpec& spec : specs)
        for (const EndKind start : {EndKind::free, EndKind::pinned, EndKind::clamped, EndKind::clamped_frozen})
            for (const EndKind end : {EndKind::free, EndKind::pinned, EndKind::clamped_frozen}) {
                RodSpec held = spec;
                held.start = start;
                held.end = end;
                rods.emplace_back(held, 0, 0, "");
            }
    for (const RodSpec& spec : {ring, rough}) rods.emplace_back(spec, 0, 0, "");
    return rods;
}

/// Moves at random, and where it is held not at all.
State moving(const RodGroup& group, unsigned seed) {
    State state = test::shaken_state(group, 0.01, 0.8, 1, seed);
    for (int i = 0; i <= group.elements(); ++i) {
        if (group.holds_node(i)) set_lane(nth(state, i).velocity, 0, Vec3d{0, 0, 0});
        if (i < group.elements() && group.holds_element(i)) set_lane(nth(state, i).spin, 0, Vec3d{0, 0, 0});
    }
    if (group.closed()) state.back().velocity = state.front().velocity;
    return state;
}

// Of a uniform rod cosines with crests at both ends are the modes, of a ring all waves.
TEST(LaplacianFilter, DampsWavesByTheClosedForm) {
    const Vec3d axis{1, -2, 0.5};
    for (const bool closed : {false, true})
        for (const long order : {1, 2, 5})
            for (const int mode : {0, 1, 4, 9, 11}) {
                RodSpec spec = test::simple_rod(12);
                spec.shape.closed = closed;
                const RodGroup group(spec, 0, 0, "");
                State start = test::shaken_state(group, 0, 0, 0);
                const auto wave = [&](double at, double count) {
                    return closed ? std::cos(2 * pi * mode * at / 12 + 0.3) : std::cos(pi * mode * at / count);
                };
                for (std::size_t i = 0; i <= 12; ++i) {
                    const double at = static_cast<double>(i);
                    set_lane(start[i].velocity, 0, wave(at, 12) * axis);
                    if (i < 12 && !closed) set_lane(start[i].spin, 0, wave(at + 0.5, 12) * axis);
                }
                const State end = filtered(group, start, order, 40, 0.01);
                const double theta = closed ? 2 * pi * mode / 12.0 : pi * mode / 12.0;
                const double share = saved(std::pow(std::sin(0.5 * theta), 2.0 * static_cast<double>(order)), 0.4);
                for (std::size_t i = 0; i < (closed ? 12 : 13); ++i) {
                    const Vec3d expected = share * lane(start[i].velocity, 0), spin = share * lane(start[i].spin, 0);
                    EXPECT_LT(norm(lane(end[i].velocity, 0) - expected), 1e-14) << order << " " << mode;
                    if (i < 12) {
                        EXPECT_LT(norm(lane(end[i].spin, 0) - spin), 1e-14) << order << " " << mode;
                    }
                }
            }
}

// What the filter takes is a symmetric form between nothing and all there is, so no mode gains and none is turned
// round.
TEST(LaplacianFilter, HasGainsBetweenNoneAndOne) {
    for (const RodGroup& group : all_rods())
        for (const long order : {1, 2, 7})
            for (const double z : {1e-3, 0.7, 50.0})
                for (unsigned seed = 1; seed < 4; ++seed) {
                    State a = moving(group, seed), b = a;
                    for (std::size_t i = 0; i < a.size(); ++i) { // the same place, other rates; one zigzag among them
                        const double turn = i % 2 == 0 ? 1 : -1;
                        const auto other = [&](auto& rate) {
                            const Vec3d v = lane(rate, 0);
                            set_lane(rate, 0,
                                     norm(v) == 0 ? v
                                     : seed == 1  ? Vec3d{turn, 2 * turn, 0}
                                                  : Vec3d{v.y, -v.z, v.x});
                        };
                        other(b[i].velocity);
                        other(b[i].spin);
                    }
                    if (group.closed()) b.back().velocity = b.front().velocity;
                    const State fa = filtered(group, a, order, z, 1), fb = filtered(group, b, order, z, 1);
                    const Products aa = product(group, a, a), bb = product(group, b, b), ab = product(group, a, fb),
                                   ba = product(group, b, fa);
                    EXPECT_NEAR(ab.nodes, ba.nodes, 1e-13 * std::sqrt(aa.nodes * bb.nodes));
                    EXPECT_NEAR(ab.elements, ba.elements, 1e-12 * std::sqrt(aa.elements * bb.elements));
                    for (const auto& [before, after] : {std::pair{&a, &fa}, {&b, &fb}}) {
                        const Products all = product(group, *before, *before), left = product(group, *before, *after);
                        EXPECT_GE(left.nodes, -1e-14 * all.nodes);
                        EXPECT_LE(left.nodes, (1 + 1e-14) * all.nodes);
                        EXPECT_GE(left.elements, -1e-13 * all.elements);
                        EXPECT_LE(left.elements, (1 + 1e-13) * all.elements);
                    }
                }
}

TEST(LaplacianFilter, KeepsMomentaAndSparesRigidSpin) {
    for (const RodGroup& group : all_rods()) {
        if (group.spec().start != EndKind::free || group.spec().end != EndKind::free) continue;
        const auto of_spins = [&](const State& state) {
            Vec3d sum{0, 0, 0};
            for (std::size_t k = 0; k + 1 < state.size(); ++k)
                sum += transpose_times(lane(state[k].director, 0),
                                       scale(group.element[k].inertia, lane(state[k].spin, 0)));
            return sum;
        };
        for (const long order : {1, 3}) {
            State state = moving(group, 5);
            const State end = filtered(group, state, order, 1, 1);
            const auto size = product(group, state, state);
            double mass = 0, inertia = 0;
            for (const double m : group.node_mass) mass += m;
            for (const ElementConstants& c : group.element) inertia += norm(c.inertia);
            EXPECT_LT(norm(test::momenta(group, end).linear - test::momenta(group, state).linear),
                      1e-15 * std::sqrt(size.nodes * mass));
            EXPECT_LT(norm(of_spins(end) - of_spins(state)), 1e-14 * std::sqrt(size.elements * inertia));

            const Vec3d v{0.3, -2, 1}, w{5, 1, -3};
            for (auto& s : state) {
                set_lane(s.velocity, 0, v);
                set_lane(s.spin, 0, lane(s.director, 0) * w);
            }
            const State same = filtered(group, state, order, 1, 1);
            for (std::size_t k = 0; k + 1 < state.size(); ++k) {
                EXPECT_EQ(norm(lane(same[k].velocity, 0) - v), 0);
                EXPECT_LT(norm(lane(same[k].spin, 0) - lane(state[k].spin, 0)), 1e-14 * norm(w));
            }
        }
    }
}

TEST(LaplacianFilter, DragsNodesTowardsTheWallThatHoldsThem) {
    RodSpec spec = test::crooked_rod(6);
    spec.start = EndKind::clamped_frozen;
    const RodGroup group(spec, 0, 0, "");
    State state = test::shaken_state(group, 0, 0, 0);
    const Vec3d v{1, 2, 3};
    for (auto& s : state) set_lane(s.velocity, 0, v);
    const State along = filtered(group, state, 2, 1, 1);
    for (std::size_t i = 0; i <= 6; ++i) EXPECT_EQ(norm(lane(along[i].velocity, 0) - v), 0) << "moves with its wall";
    set_lane(state[0].velocity, 0, Vec3d{0, 0, 0});
    const State end = filtered(group, state, 2, 1, 1);
    EXPECT_EQ(norm(lane(end[0].velocity, 0)), 0);
    EXPECT_LT(dot(lane(end[1].velocity, 0), v), dot(v, v));
}

// Over h and over two halves of it: apart by the third power of h.
TEST(LaplacianFilter, IsOfSecondOrderInTime) {
    const RodGroup group(test::crooked_rod(8), 0, 0, "");
    const State start = moving(group, 3);
    const auto apart = [&](double z) {
        const State once = filtered(group, start, 2, z, 1);
        State twice = filtered(group, filtered(group, start, 2, 0.5 * z, 1), 2, 0.5 * z, 1);
        double sum = 0;
        for (std::size_t i = 0; i < once.size(); ++i) {
            sum += norm(lane(once[i].velocity, 0) - lane(twice[i].velocity, 0));
            if (i + 1 < once.size()) sum += norm(lane(once[i].spin, 0) - lane(twice[i].spin, 0));
        }
        return sum;
    };
    EXPECT_NEAR(apart(0.02) / apart(0.01), 8, 0.3);
}

TEST(LaplacianFilter, HasTheSameBitsInAllLanes) {
    for (const bool closed : {false, true}) {
        RodSpec spec = closed ? test::simple_rod(9) : test::crooked_rod(9);
        spec.shape.closed = closed;
        const RodGroup group(spec, 0, 0, "");
        std::vector<Slot<8>> wide(10);
        std::vector<State> states;
        for (unsigned i = 0; i < 8; ++i) {
            states.push_back(moving(group, i + 1));
            for (std::size_t k = 0; k < wide.size(); ++k) set_lane(wide[k], static_cast<int>(i), states.back()[k]);
        }
        std::vector<SlotLoad<8>> load(10);
        const RodTile<8> tile{
            wide.data(), group.element.data(), group.voronoi.data(), &group, group.elements(), 0, {}, 8};
        LaplacianFilterPass<8>(group, 3, 5, 0.1).run(tile, load.data(), Step{});
        for (int i = 0; i < 8; ++i) {
            const State one = filtered(group, nth(states, i), 3, 5, 0.1);
            for (std::size_t k = 0; k < one.size(); ++k) {
                EXPECT_EQ(norm(lane(wide[k].velocity, i) - lane(one[k].velocity, 0)), 0);
                EXPECT_EQ(norm(lane(wide[k].spin, i) - lane(one[k].spin, 0)), 0);
            }
        }
    }
}

} // namespace
} // namespace skein
