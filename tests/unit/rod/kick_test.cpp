// The kick is what its scheme says for every damping law; held ends do not move.
#include "loads/damping.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

constexpr double h = 0.013;

std::vector<SlotLoad<1>> some_loads(std::size_t slots) {
    std::vector<SlotLoad<1>> load(slots);
    for (std::size_t k = 0; k < slots; ++k) {
        const double s = 1 + 0.1 * static_cast<double>(k);
        set_lane(load[k].force, 0, Vec3d{s, -2 * s, 0.5});
        set_lane(load[k].couple, 0, Vec3d{1e-3 * s, 2e-3, -1e-3 * s});
    }
    return load;
}

double dilatation(const RodGroup& group, std::span<const Slot<1>> state, std::size_t k) {
    return dot(frame(state[k]).d3, lane(state[k + 1].position, 0) - lane(state[k].position, 0)) /
           group.element[k].rest_length;
}

template <KickKind Kind> std::vector<Slot<1>> kicked(const RodGroup& group, const std::vector<Damping>& damping,
                                                     std::vector<Slot<1>> state,
                                                     DampingScheme scheme = DampingScheme::midpoint) {
    auto load = some_loads(state.size());
    for (std::size_t k = 0; k + 1 < state.size(); ++k) load[k].dilatation = dilatation(group, state, k);
    KickPass<Kind, 1>({KickConstants(group, damping_rates(group, damping), h, scheme)})
        .run(test::tile_of(group, state), load.data(), Step{});
    return state;
}

/// v' = a - nu v over time h, in long double: exactly, by the implicit midpoint (all of the force lost above z = 2), or
/// damped after.
double flow(DampingScheme scheme, double v, double a, double nu) {
    const long double z = static_cast<long double>(nu) * h;
    if (z == 0) return v + a * h;
    if (scheme == DampingScheme::exponential) return static_cast<double>(std::exp(-z) * v - std::expm1(-z) / z * h * a);
    if (scheme == DampingScheme::after)
        return static_cast<double>(std::exp(-z) * (v + h * static_cast<long double>(a)));
    return static_cast<double>(z < 2 ? ((1 - z / 2) * v + h * static_cast<long double>(a)) / (1 + z / 2) : h / z * a);
}

class Kick : public testing::TestWithParam<DampingScheme> {};

TEST_P(Kick, IsWhatItsSchemeSaysForEveryDampingLaw) {
    const DampingScheme scheme = GetParam();
    const RodGroup group(test::crooked_rod(), 0, 0, "");
    const auto start = test::shaken_state(group, 0.01, 0.3, 0.7);
    const auto load = some_loads(start.size());
    struct Case {
        std::vector<Damping> damping;
        std::vector<Slot<1>> end;
    };
    std::vector<Case> cases = {
        {{}, {}},
        {{{.kind = DampingKind::uniform, .rate = 3}}, {}},
        {{{.kind = DampingKind::legacy, .rate = 0.5}}, {}},
        {{{.kind = DampingKind::physical, .translational = 0.4, .rotational = 1e-6}}, {}},
        {{{.kind = DampingKind::uniform, .rate = 3}, {.kind = DampingKind::legacy, .rate = 1e-3}}, {}}};
    cases[0].end = kicked<KickKind::undamped>(group, cases[0].damping, start);
    cases[1].end = kicked<KickKind::constant_rates>(group, cases[1].damping, start, scheme);
    const auto stretched = [&](const std::vector<Damping>& damping) {
        if (scheme == DampingScheme::midpoint) return kicked<KickKind::stretched_rates>(group, damping, start, scheme);
        if (scheme == DampingScheme::exponential)
            return kicked<KickKind::stretched_exponential>(group, damping, start, scheme);
        return kicked<KickKind::stretched_after>(group, damping, start, scheme);
    };
    for (std::size_t i = 2; i < cases.size(); ++i) cases[i].end = stretched(cases[i].damping);

    for (const Case& c : cases) {
        for (std::size_t i = 0; i < start.size(); ++i) {
            double nu = 0;
            for (const Damping& d : c.damping)
                nu += d.kind == DampingKind::physical ? d.translational / group.node_mass[i] : d.rate;
            const Vec3d a = (1 / group.node_mass[i]) * lane(load[i].force, 0), v = lane(start[i].velocity, 0);
            EXPECT_NEAR(c.end[i].velocity.y[0], flow(scheme, v.y, a.y, nu),
                        1e-12 * (std::abs(v.y) + std::abs(a.y) * h));
        }
        for (std::size_t k = 0; k + 1 < start.size(); ++k) {
            const ElementConstants& e = group.element[k];
            const double stretch = dilatation(group, start, k);
            double mass = 0.5 * (group.node_mass[k] + group.node_mass[k + 1]);
            if (k == 0) mass += 0.5 * group.node_mass[0];
            if (k + 2 == start.size()) mass += 0.5 * group.node_mass[k + 1];
            for (double Vec3d::*axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
                const double j = e.inertia.*axis;
                double nu = 0;
                for (const Damping& d : c.damping)
                    nu += d.kind == DampingKind::uniform  ? d.rate
                          : d.kind == DampingKind::legacy ? d.rate * mass * stretch / j
                                                          : d.rotational * stretch / j;
                const double a = lane(load[k].couple, 0).*axis / j, w = lane(start[k].spin, 0).*axis;
                EXPECT_NEAR(lane(c.end[k].spin, 0).*axis, flow(scheme, w, a, nu),
                            1e-12 * (std::abs(w) + std::abs(a) * h))
                    << "element " << k;
            }
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Schemes, Kick,
                         testing::Values(DampingScheme::midpoint, DampingScheme::exponential, DampingScheme::after));

TEST(HeldEnds, StayAtRest) {
    RodSpec spec = test::simple_rod();
    spec.start = EndKind::clamped_frozen;
    spec.end = EndKind::pinned;
    const RodGroup group(spec, 0, 0, "");
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    group.start_state(0, state);
    for (const auto& end :
         {kicked<KickKind::undamped>(group, {}, state),
          kicked<KickKind::stretched_rates>(group, {{.kind = DampingKind::legacy, .rate = 1}}, state)}) {
        EXPECT_EQ(norm(lane(end.front().velocity, 0)), 0);
        EXPECT_EQ(norm(lane(end.front().spin, 0)), 0);
        EXPECT_EQ(norm(lane(end.back().velocity, 0)), 0);
        EXPECT_GT(norm(lane(end[1].velocity, 0)), 0);
        EXPECT_GT(norm(lane(end[1].spin, 0)), 0);
        EXPECT_GT(norm(lane(end[end.size() - 2].spin, 0)), 0) << "a pin leaves the last element free to turn";
    }
}

} // namespace
} // namespace skein
