// Strains at nodes, for those who look: against closed forms, and against the energies of the observables for every law
// and end.
#include "diagnostics/observables.hpp"
#include "mechanics/rod_copies.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"
#include "tiles/rods.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace skein {
namespace {

std::vector<NodeProfile> profile_of(const RodGroup& group, std::span<const Slot<1>> state, double time = 0) {
    std::vector<NodeProfile> profile(state.size());
    rod_profile(group, state, time, profile);
    return profile;
}

/// Of all nodes; a ring's last is its first.
double whole_energy(const RodGroup& group, const std::vector<NodeProfile>& profile) {
    const std::size_t n = group.element.size();
    double sum = 0;
    for (std::size_t k = 0; k < n; ++k)
        sum += 0.5 * group.element[k].rest_length * (profile[k].energy + profile[k + 1].energy);
    return sum;
}

TEST(RodProfile, SumsUpToTheElasticEnergyOfEveryLawAndEnd) {
    for (const Law law : {Law::incompressible, Law::linear, Law::elastica, Law::neo_hookean})
        for (const EndKind start : {EndKind::free, EndKind::pinned, EndKind::clamped, EndKind::clamped_frozen})
            for (const EndKind end : {EndKind::free, EndKind::pinned, EndKind::clamped, EndKind::clamped_frozen})
                for (const bool closed : {false, true}) {
                    RodSpec spec = test::crooked_rod(9);
                    if (law == Law::elastica) { // which knows neither, and no walls but frozen ones
                        spec = test::simple_rod(9);
                        if (closed || start == EndKind::clamped || end == EndKind::clamped) continue;
                    }
                    if (closed && (start != EndKind::free || end != EndKind::free)) continue;
                    if (closed) {
                        spec = test::simple_rod(9);
                        spec.shape.rest_curvature = {2 * std::numbers::pi, 0, 0};
                    }
                    spec.material.law = law;
                    spec.start = start;
                    spec.end = end;
                    spec.shape.closed = closed;
                    const RodGroup group(spec, 0, 0, "");
                    auto state = test::shaken_state(group, 1e-3, 0.05, 0);
                    if (closed) state.back().position = state.front().position;
                    const RodEnergy u = rod_energy(group, state, 0);
                    const double expected = u.stretch + u.shear + u.bend + u.twist;
                    EXPECT_GT(expected, 0);
                    EXPECT_NEAR(whole_energy(group, profile_of(group, state)), expected, 1e-13 * expected)
                        << nth(law_names, law) << ", " << nth(end_names, start) << ", " << nth(end_names, end)
                        << (closed ? ", closed" : "");
                }
}

TEST(RodProfile, OfARodBentAndStretchedEvenly) {
    const RodGroup group(test::simple_rod(20), 0, 0, "");
    const Vec3d curvature{1.2, -0.9, 2};
    const double l = group.element[0].rest_length;
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    Quaterniond q = rotation((0.5 * l) * curvature);
    Vec3d x{0, 0, 0};
    for (std::size_t k = 0; k < state.size(); ++k) {
        set_lane(state[k].position, 0, x);
        if (k + 1 == state.size()) break;
        set_lane(state[k].director, 0, q);
        x += (1.01 * l) * third_director(q);
        q = rotation(l * curvature) * q;
    }
    const auto profile = profile_of(group, state);
    for (std::size_t i = 0; i < profile.size(); ++i) {
        EXPECT_NEAR(profile[i].strain, 0.01, 1e-13);
        EXPECT_NEAR(profile[i].curvature, i == 0 || i + 1 == profile.size() ? 0 : 1.5, 1e-12);
    }
}

TEST(RodProfile, OfARigidBodyIsNothing) {
    const RodGroup group(test::rigid_body(0.1, 0.02), 0, 0, "");
    for (const NodeProfile& p : profile_of(group, test::shaken_state(group, 0, 0, 1))) {
        EXPECT_EQ(p.strain, 0);
        EXPECT_EQ(p.curvature, 0);
        EXPECT_EQ(p.energy, 0);
    }
}

} // namespace
} // namespace skein
