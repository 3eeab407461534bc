// Free tops: angular momentum kept, second order for J1 != J2, exact for J1 = J2, reversible, no drift off SO(3).
#include "mechanics/gyration.hpp"
#include "mechanics/rod_copies.hpp"
#include "support/rods_for_tests.hpp"
#include "tiles/rods.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

/// A rod group whose elements are tops: what matters here are their inertias.
RodGroup tops(double semi_axis_1, double semi_axis_2, double transverse_scale = 1) {
    RodSpec spec = test::simple_rod(2);
    spec.material.rotary_inertia_scale = transverse_scale;
    spec.section = {.kind = SectionKind::elliptic, .radius = semi_axis_1, .radius_2 = semi_axis_2};
    return RodGroup(spec, 0, 0, "");
}

Vec3d angular_momentum(const RodGroup& group, const Slot<1>& s) {
    return transpose_times(lane(s.director, 0), scale(group.element[0].inertia, lane(s.spin, 0)));
}

std::vector<Slot<1>> spinning(const RodGroup& group) { return test::shaken_state(group, 0, 0.5, 1, 3); }

/// Turns a top for `time` in `steps` equal drifts.
std::vector<Slot<1>> turned(const RodGroup& group, double time, int steps) {
    std::vector<Slot<1>> state = spinning(group);
    const OrthonormalisePass<1> orthonormalise;
    for (int i = 1; i <= steps; ++i) {
        synchronise(group, state, time / steps);
        orthonormalise.run(test::tile_of(group, state), nullptr, Step{.index = i, .completes = true});
    }
    return state;
}

double frame_distance(const Slot<1>& a, const Slot<1>& b) {
    return norm(frame(a).d1 - frame(b).d1) + norm(frame(a).d3 - frame(b).d3);
}

TEST(Drift, CircularTopIsExactWhateverTheStep) {
    for (const double j : {1.0, 2.0, 25.0}) { // discs, spheres, rods
        const RodGroup group = tops(0.02, 0.02, j);
        const auto once = turned(group, 0.3, 1), often = turned(group, 0.3, 1000);
        EXPECT_LT(frame_distance(once[0], often[0]), 1e-12) << "j = " << j;
        EXPECT_LT(norm(lane(once[0].spin, 0) - lane(often[0].spin, 0)), 1e-12 * norm(lane(once[0].spin, 0)))
            << "j = " << j;
    }
}

TEST(Drift, EllipticTopIsSecondOrder) {
    for (const auto& [a, b] : {std::pair{0.02, 0.01}, std::pair{0.01, 0.02}, std::pair{0.04, 0.01}}) {
        const RodGroup group = tops(a, b);
        const auto exact = turned(group, 2.0, 16000);
        const double coarse = frame_distance(turned(group, 2.0, 400)[0], exact[0]),
                     fine = frame_distance(turned(group, 2.0, 800)[0], exact[0]);
        EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.1) << a << " x " << b << ": " << coarse << ", " << fine;
    }
}

TEST(Drift, EllipticTopOfScaledInertiaIsSecondOrder) {
    for (const auto& [a, b] : {std::pair{0.02, 0.01}, std::pair{0.01, 0.02}}) {
        const RodGroup group = tops(a, b, 25); // d3 now has the smallest inertia
        ASSERT_LT(group.element[0].inertia.z, std::min(group.element[0].inertia.x, group.element[0].inertia.y));
        const auto exact = turned(group, 2.0, 16000);
        const double coarse = frame_distance(turned(group, 2.0, 400)[0], exact[0]),
                     fine = frame_distance(turned(group, 2.0, 800)[0], exact[0]);
        EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.1) << a << " x " << b << ": " << coarse << ", " << fine;
    }
}

TEST(Drift, AngularMomentumIsKept) {
    for (const double j : {1.0, 25.0})
        for (const auto& [a, b] : {std::pair{0.02, 0.02}, std::pair{0.03, 0.01}, std::pair{0.01, 0.03}}) {
            const RodGroup group = tops(a, b, j);
            const Vec3d before = angular_momentum(group, spinning(group)[0]);
            EXPECT_LT(norm(angular_momentum(group, turned(group, 20.0, 10000)[0]) - before), 1e-12 * norm(before));
        }
}

TEST(Drift, IsReversible) {
    const RodGroup group = tops(0.03, 0.01);
    std::vector<Slot<1>> state = spinning(group);
    const auto start = state;
    for (int i = 0; i < 500; ++i) synchronise(group, state, 4e-3);
    for (int i = 0; i < 500; ++i) synchronise(group, state, -4e-3);
    EXPECT_LT(frame_distance(state[0], start[0]), 1e-11);
}

TEST(Drift, OrthonormalisationRemovesWhatRoundOffLeaves) {
    const RodGroup group = tops(0.02, 0.02);
    std::vector<Slot<1>> state = spinning(group);
    state[0].director.v = Pack<1>(1 + 1e-7) * state[0].director.v;
    OrthonormalisePass<1>().run(test::tile_of(group, state), nullptr,
                                Step{.index = OrthonormalisePass<1>::interval, .completes = true});
    const Mat3d q = frame(state[0]);
    EXPECT_NEAR(dot(q.d1, q.d1), 1, 1e-13);
    EXPECT_NEAR(dot(q.d1, q.d2), 0, 1e-13);
    EXPECT_NEAR(dot(state[0].director, state[0].director)[0], 1, 1e-13);
    const auto before = state;
    OrthonormalisePass<1>().run(test::tile_of(group, state), nullptr,
                                Step{.index = OrthonormalisePass<1>::interval + 1, .completes = true});
    EXPECT_EQ(frame_distance(before[0], state[0]), 0) << "acts only every so many steps";
}

} // namespace
} // namespace skein
