// Scaled rotary inertia: how far it lifts the step, and how far it slows bending.
#include "mechanics/bending_shift.hpp"
#include "mechanics/elastic.hpp"
#include "mechanics/gyration.hpp"
#include "mechanics/kick.hpp"
#include "rod/time_limits.hpp"
#include "skein/core/error.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

RodSpec slender(double radius, double scale, EndKind start = EndKind::free, EndKind end = EndKind::free) {
    RodSpec spec = test::simple_rod(20);
    spec.section.radius = radius;
    spec.material.rotary_inertia_scale = scale;
    spec.start = start;
    spec.end = end;
    return spec;
}

double shear_rotation_limit(const RodGroup& group) {
    for (const TimeLimit& limit : time_limits(group))
        if (limit.mode.starts_with("shear-rotation")) return limit.dt;
    return 0;
}

TEST(RotaryInertia, IsScaledAboutD1AndD2Alone) {
    RodSpec spec = test::crooked_rod();
    const RodGroup plain(spec, 0, 0, "");
    spec.material.rotary_inertia_scale = 25;
    const RodGroup scaled(spec, 0, 0, "");
    for (std::size_t k = 0; k < plain.element.size(); ++k) {
        const ElementConstants &a = plain.element[k], &b = scaled.element[k];
        EXPECT_EQ(b.inertia.x, 25 * a.inertia.x);
        EXPECT_EQ(b.inertia.y, 25 * a.inertia.y);
        EXPECT_EQ(b.inertia.z, a.inertia.z);
        EXPECT_DOUBLE_EQ(b.inertia_ratio, b.inertia.z / b.inertia.x);
        EXPECT_DOUBLE_EQ(b.inv_inertia.x * b.inertia.x, 1);
        EXPECT_EQ(b.inv_inertia.z, a.inv_inertia.z);
    }
    EXPECT_EQ(scaled.node_mass, plain.node_mass);
}

TEST(RotaryInertia, LiftsTheLimitOfThinRodsByItsRoot) {
    const double plain = shear_rotation_limit(RodGroup(slender(0.001, 1), 0, 0, ""));
    for (const double j : {4.0, 25.0}) { // r sqrt(j) far below an element's length of 0.05
        const double scaled = shear_rotation_limit(RodGroup(slender(0.001, j), 0, 0, ""));
        EXPECT_NEAR(scaled / plain, std::sqrt(j), 0.01 * std::sqrt(j));
    }
}

TEST(RotaryInertia, ForAStepIsTheLeastThatReachesIt) {
    for (const bool crooked : {false, true})
        for (const EndKind start : {EndKind::free, EndKind::clamped}) {
            RodSpec spec = crooked ? test::crooked_rod(20) : slender(0.016, 1);
            spec.start = start;
            const double aim = 1.5 * shear_rotation_limit(RodGroup(spec, 0, 0, ""));
            spec.material.rotary_inertia_for_dt = aim;
            const RodGroup group(spec, 0, 0, "");
            EXPECT_GE(shear_rotation_limit(group), aim);
            // The element that set the limit has no more than it needs.
            EXPECT_NEAR(shear_rotation_limit(group), aim, 1e-3 * aim) << (crooked ? "crooked" : "straight");
            ASSERT_EQ(group.rotary_inertia_scale.size(), 20u);
            for (const double j : group.rotary_inertia_scale) EXPECT_GE(j, 1);
        }
}

TEST(RotaryInertia, ForAStepLeavesElementsAloneThatReachIt) {
    RodSpec spec = slender(0.016, 1);
    spec.section.taper = 0.2;
    const double limit = shear_rotation_limit(RodGroup(spec, 0, 0, ""));
    spec.material.rotary_inertia_for_dt = 1.5 * limit;
    const RodGroup group(spec, 0, 0, "");
    EXPECT_EQ(group.rotary_inertia_scale.front(), 1) << "the thick end";
    EXPECT_GT(group.rotary_inertia_scale.back(), 2) << "the thin end";
    spec.material.rotary_inertia_for_dt = 0.9 * limit;
    EXPECT_TRUE(RodGroup(spec, 0, 0, "").rotary_inertia_scale.empty());
}

TEST(RotaryInertia, CannotLiftTheLimitOfShearItself) {
    RodSpec spec = slender(0.016, 1);
    spec.material.rotary_inertia_for_dt = 1;
    EXPECT_THROW(RodGroup(spec, 0, 0, ""), InputError);
}

/// Frequency of a rod let go in a bent shape, by its projection on that shape, a cosine: a(t+T) + a(t-T) = 2 cos(W T)
/// a(t).
double frequency(const RodGroup& group, const std::vector<double>& w, double dt, int steps, int lag) {
    std::vector<Slot<1>> state(w.size());
    group.start_state(0, state);
    for (std::size_t k = 0; k < w.size(); ++k) {
        set_lane(state[k].position, 0, lane(state[k].position, 0) + Vec3d{1e-5 * w[k], 0, 0});
        if (k + 1 < w.size())
            set_lane(state[k].director, 0,
                     rotation({0, 1e-5 * (w[k + 1] - w[k]) * group.element[k].inv_rest_length, 0}) *
                         lane(state[k].director, 0));
    }
    const RodTile<1> tile = test::tile_of(group, state);
    const ElasticPass<IncompressibleLaw, 1> elastic(ends_of(group));
    const KickPass<KickKind::undamped, 1> kick({KickConstants(group, {}, dt)});
    std::vector<SlotLoad<1>> load(state.size());
    std::vector<double> a;
    for (int i = 0; i < steps; ++i) {
        drift<CircularGyration>(tile, i == 0 ? 0.5 * dt : dt);
        elastic.run(tile, load.data(), Step{});
        kick.run(tile, load.data(), Step{});
        double sum = 0;
        for (std::size_t k = 0; k < w.size(); ++k) sum += group.node_mass[k] * w[k] * lane(state[k].position, 0).x;
        a.push_back(sum);
    }
    double product = 0, square = 0;
    for (std::size_t i = static_cast<std::size_t>(lag); i + static_cast<std::size_t>(lag) < a.size(); ++i) {
        product += a[i] * (a[i - static_cast<std::size_t>(lag)] + a[i + static_cast<std::size_t>(lag)]);
        square += 2 * a[i] * a[i];
    }
    return std::acos(product / square) / (lag * dt);
}

TEST(RotaryInertia, SlowsBendingAsEstimated) {
    const double radius = 0.016; // aspect 31
    const auto free_mode = [](double x) {
        const double b = 4.730040744862704, c = (std::cosh(b) - std::cos(b)) / (std::sinh(b) - std::sin(b));
        return std::cosh(b * x) + std::cos(b * x) - c * (std::sinh(b * x) + std::sin(b * x));
    };
    const auto clamped_mode = [](double x) {
        const double b = 1.875104068711961, c = (std::cosh(b) + std::cos(b)) / (std::sinh(b) + std::sin(b));
        return std::cosh(b * x) - std::cos(b * x) - c * (std::sinh(b * x) - std::sin(b * x));
    };
    for (const bool clamped : {false, true}) {
        const EndKind start = clamped ? EndKind::clamped : EndKind::free;
        const RodGroup plain(slender(radius, 1, start), 0, 0, ""), scaled(slender(radius, 25, start), 0, 0, "");
        std::vector<double> w;
        for (int k = 0; k <= 20; ++k) w.push_back(clamped ? clamped_mode(k / 20.0) : free_mode(k / 20.0));
        const double dt = 0.5 * time_limits(plain).front().dt;
        const double slender_frequency = (clamped ? 3.516 : 22.373) * 0.5 * radius * std::sqrt(1e6 / 1000);
        const int period = static_cast<int>(2 * 3.14159265358979 / slender_frequency / dt);
        const double before = frequency(plain, w, dt, 3 * period, period / 6),
                     after = frequency(scaled, w, dt, 3 * period, period / 6);
        EXPECT_NEAR(before, slender_frequency, 0.03 * slender_frequency);
        const double shift = after / before - 1, estimate = bending_shift(scaled);
        RecordProperty(clamped ? "clamped_shift" : "free_shift", std::to_string(shift));
        RecordProperty(clamped ? "clamped_estimate" : "free_estimate", std::to_string(estimate));
        // The closed form of a slender rod: R = j r^2/4 times the integral of w'^2 over that of w^2.
        const double r = (clamped ? 4.6478 : 49.4808) * 0.25 * radius * radius;
        EXPECT_NEAR(estimate, std::sqrt((1 + r) / (1 + 25 * r)) - 1, 0.02 * std::abs(estimate));
        EXPECT_NEAR(shift, estimate, 0.05 * std::abs(estimate))
            << (clamped ? "clamped" : "free") << ": " << shift << " measured, " << estimate << " estimated";
    }
    EXPECT_EQ(bending_shift(RodGroup(slender(radius, 1), 0, 0, "")), 0);
}

TEST(RotaryInertia, ModesKnowTheEnds) {
    const auto shift = [](EndKind start, EndKind end) {
        return bending_shift(RodGroup(slender(0.016, 25, start, end), 0, 0, ""));
    };
    // Integral of w'^2 over that of w^2, length 1, of the textbook's modes.
    const auto expected = [](double integral) {
        const double r = integral * 0.25 * 0.016 * 0.016;
        return std::sqrt((1 + r) / (1 + 25 * r)) - 1;
    };
    using enum EndKind;
    EXPECT_NEAR(shift(pinned, pinned), expected(9.8696), 2e-5);
    EXPECT_NEAR(shift(clamped, clamped), expected(12.3026), 2e-4);
    EXPECT_NEAR(shift(clamped, pinned), expected(11.5125), 2e-4);
    EXPECT_NEAR(shift(free, clamped), shift(clamped, free), 1e-12);
    // Ends that slide, of rods along z. Along the rod they bend as before; sideways a clamp is the middle of a rod
    // twice as long.
    const auto sliding = [](EndKind start, EndKind end, const char* end_free) {
        RodSpec spec = slender(0.016, 25, start, end);
        spec.end_free = end_free;
        return bending_shift(RodGroup(spec, 0, 0, ""));
    };
    EXPECT_EQ(sliding(clamped, clamped, "z"), shift(clamped, clamped));
    EXPECT_NEAR(sliding(clamped, clamped, "xz"), expected(12.3026 / 4), 1e-4);
    EXPECT_NEAR(sliding(pinned, clamped, "y"), expected(9.8696 / 4), 1e-4);
    EXPECT_EQ(sliding(clamped, pinned, "xz"), shift(clamped, free));
    EXPECT_NEAR(shift(free, pinned), shift(pinned, free), 1e-12);
    EXPECT_LT(shift(free, pinned), shift(pinned, pinned));
}

} // namespace
} // namespace skein
