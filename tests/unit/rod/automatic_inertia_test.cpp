// Rotary inertia by "auto": modes of a rod against closed forms, and what the choice costs and gains with sections,
// supports and curvatures of all kinds.
#include "rod/automatic_inertia.hpp"

#include "rod/rod_modes.hpp"
#include "rod/time_limits.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

namespace skein {
namespace {

constexpr double pi = std::numbers::pi;

RodSpec thin(int n, EndKind start, EndKind end, double radius = 0.002) {
    RodSpec spec = test::simple_rod(n);
    spec.section.radius = radius;
    spec.start = start;
    spec.end = end;
    return spec;
}

RodGroup made(const RodSpec& spec) { return RodGroup(spec, 0, 0, ""); }

double frequency(const RodSpec& spec, std::size_t mode) {
    return std::sqrt(slowest_bending(made(spec), mode + 1).at(mode).eigenvalue);
}

/// Of bending of a slender rod of length 1, over the square of a root.
double slender(const RodSpec& spec) {
    return 0.5 * spec.section.radius * std::sqrt(spec.material.youngs_modulus / spec.material.density);
}

TEST(RodModes, OfPinnedRodsAreThoseOfAChain) {
    for (const int n : {5, 20, 60}) {
        const RodSpec spec = thin(n, EndKind::pinned, EndKind::pinned);
        for (std::size_t i = 0; i < 6; ++i) {
            const double wave = 2 * n * std::sin(0.5 * pi * static_cast<double>(i / 2 + 1) / n);
            if (i / 2 + 1 == static_cast<std::size_t>(n)) continue;
            EXPECT_NEAR(frequency(spec, i), slender(spec) * wave * wave, 1e-3 * slender(spec) * wave * wave) << n;
        }
    }
}

/// Modes of the last rods are kept; of each rod here, one number is another.
TEST(RodModes, AreNotThoseOfAnotherRodThatCameBefore) {
    const RodSpec first = thin(40, EndKind::clamped, EndKind::free);
    const auto slowest = [](const RodSpec& spec) { return slowest_bending(made(spec), 3).front(); };
    const RodMode before = slowest(first);
    const auto expect_ratio = [&](RodSpec spec, double ratio, const char* what) {
        EXPECT_NEAR(slowest(spec).eigenvalue / before.eigenvalue, ratio, 1e-2 * ratio) << what;
        const RodMode again = slowest(first);
        EXPECT_EQ(again.eigenvalue, before.eigenvalue) << what;
        EXPECT_EQ(again.turn.back().x, before.turn.back().x) << what;
        EXPECT_EQ(slowest_bending(made(first), 1).size(), 1u) << what;
    };
    RodSpec stiff = first, heavy = first, far = first, held = first;
    stiff.material.youngs_modulus *= 3;
    expect_ratio(stiff, 3, "stiffness");
    heavy.material.density *= 3;
    expect_ratio(heavy, 1.0 / 3, "mass");
    far.shape.length *= 1.5;
    expect_ratio(far, std::pow(1.5, -4), "length");
    held.end = EndKind::pinned;
    expect_ratio(held, std::pow(3.9266 / 1.8751, 4), "supports");
}

TEST(RodModes, KnowTheEnds) {
    using enum EndKind;
    const auto expect_root = [](RodSpec spec, double root, const char* what) {
        const double exact = (4 * frequency(with_elements(spec, 60), 0) - frequency(spec, 0)) / 3;
        EXPECT_NEAR(exact, slender(spec) * root * root, 2e-3 * exact) << what;
    };
    expect_root(thin(30, clamped, free), 1.8751, "clamped");
    expect_root(thin(30, free, free), 4.7300, "free");
    expect_root(thin(30, pinned, free), 3.9266, "pinned at one end");
    expect_root(thin(30, clamped, pinned), 3.9266, "clamped and pinned");
    expect_root(thin(30, clamped, clamped), 4.7300, "between clamps");
    RodSpec guided = thin(30, clamped, clamped);
    guided.end_free = "xy"; // the rod lies along z
    expect_root(guided, 2.3650, "guided");
    RodSpec held = thin(30, pinned, pinned);
    held.hold.nodes = {15};
    expect_root(held, 2 * pi, "held in the middle");
    RodSpec ring = test::simple_rod(30);
    ring.section.radius = 0.002;
    ring.shape.closed = true;
    ring.shape.rest_curvature = {2 * pi, 0, 0};
    // Of two waves: out of the plane n (n^2 - 1)/sqrt(n^2 + 1 + nu), GJ = EI/(1 + nu) with G = E/3.
    const double twist = 2.0 / 3.0;
    expect_root(ring, 2 * pi * std::sqrt(6 / std::sqrt(4 + 1 / twist)), "ring");
}

/// Largest shares of the two lowest modes of each plane, with the inertia itself, against rods of many elements.
double measured_share(const RodSpec& spec, double dt, bool round) {
    const long n = spec.shape.elements;
    RodSpec heavy = with_elements(spec, n);
    heavy.material.rotary_inertia_for_dt = dt;
    double largest = 0;
    const std::size_t most = round ? 4 : 2;
    for (std::size_t i = round ? 1 : 0; i < most; i += round ? 2 : 1) {
        const double plain = frequency(with_elements(spec, n), i), chosen = frequency(heavy, i),
                     two = frequency(with_elements(spec, 2 * n), i), four = frequency(with_elements(spec, 4 * n), i);
        largest = std::max(largest, (plain - chosen) / std::abs((4 * four - two) / 3 - plain));
    }
    return largest;
}

struct Case {
    const char* name;
    std::function<void(RodSpec&)> make;
    bool round = true;
    double near = 0.02; ///< of the share to that accepted
};

TEST(AutomaticInertia, ChangesBendingByAFifthOfItsErrorAtMost) {
    using enum EndKind;
    const Case cases[] = {
        {"clamped", [](RodSpec&) {}},
        {"pinned", [](RodSpec& s) { s.start = s.end = pinned; }},
        {"between clamps", [](RodSpec& s) { s.end = clamped; }},
        {"guided", [](RodSpec& s) { s.end = clamped, s.end_free = "xy"; }},
        {"taper", [](RodSpec& s) { s.section.taper = 0.4; }},
        {"lengths",
         [](RodSpec& s) {
             for (long k = 0; k < s.shape.elements; ++k)
                 s.shape.length_profile.push_back(1 + static_cast<double>(k) / static_cast<double>(s.shape.elements));
         }},
        {"weights", [](RodSpec& s) { s.shape.end_weights = EndWeights::gregory; }, true, 0.1},
        {"arc",
         [](RodSpec& s) {
             s.shape.rest_curvature = {1.5, 0, 0};
         }},
        {"helix",
         [](RodSpec& s) {
             s.shape.rest_curvature = {8, 0, 3};
         },
         true, 0.1},
        {"linear",
         [](RodSpec& s) {
             s.material.law = Law::linear, s.shape.rest_strain = {0, 0, 0.1};
         }},
        {"held", [](RodSpec& s) { s.hold.nodes = {-1}; }},
    };
    for (const auto& [name, make, round, near] : cases)
        for (const int n : {10, 20, 40}) {
            RodSpec spec = thin(n, clamped, free);
            make(spec);
            const AutomaticInertia chosen = automatic_inertia(spec);
            ASSERT_GT(chosen.dt, 0) << name;
            const double share = measured_share(spec, chosen.dt, round);
            EXPECT_LT(share, 0.2) << name << " " << n;
            EXPECT_NEAR(share, chosen.share, near) << name << " " << n;
            EXPECT_LE(chosen.share, 0.19) << name << " " << n;
            spec.material.rotary_inertia_for_dt = chosen.dt;
            const double limit = time_limits(made(spec)).front().dt,
                         plain = time_limits(made(with_elements(spec, n))).front().dt;
            EXPECT_GE(limit, chosen.dt);
            EXPECT_NEAR(limit / plain, chosen.gain, 0.01 * chosen.gain) << name << " " << n;
        }
}

TEST(AutomaticInertia, OfRibbonsCountsBothPlanes) {
    RodSpec spec = thin(20, EndKind::clamped, EndKind::free);
    spec.section.kind = SectionKind::rectangular;
    spec.section.radius_2 = 0.25 * spec.section.radius;
    const AutomaticInertia chosen = automatic_inertia(spec);
    RodSpec round = thin(20, EndKind::clamped, EndKind::free);
    round.section.radius = spec.section.radius;
    // The plane that is four times as stiff has sixteen times the inertia, and gets the longer step alone.
    const double stiff = automatic_inertia(round).dt;
    EXPECT_LT(chosen.dt, 0.5 * stiff);
    EXPECT_GT(chosen.gain, 2);
    EXPECT_LE(chosen.share, 0.19);
    RodSpec heavy = spec;
    heavy.material.rotary_inertia_for_dt = chosen.dt;
    for (std::size_t i = 0; i < 2; ++i) EXPECT_GT(frequency(heavy, i), 0.998 * frequency(spec, i)) << "the soft plane";
}

TEST(AutomaticInertia, StopsAtTheAxialLimit) {
    RodSpec spec = thin(6, EndKind::clamped, EndKind::clamped);
    spec.material.shear_modulus = 0.9 * spec.material.youngs_modulus;
    spec.material.shear_factor = 0.3;
    double axial = 0;
    for (const TimeLimit& limit : time_limits(made(spec)))
        if (limit.mode == "axial") axial = limit.dt;
    EXPECT_LE(automatic_inertia(spec).dt, axial);
    const AutomaticInertia thick = automatic_inertia(thin(40, EndKind::clamped, EndKind::free, 0.05));
    EXPECT_LT(thick.gain, 1.5);
}

TEST(AutomaticInertia, FallsWithTheSquareOfTheElements) {
    for (const auto& [start, end] : {std::pair{EndKind::clamped, EndKind::free}, {EndKind::pinned, EndKind::pinned}}) {
        const double coarse = automatic_inertia(thin(20, start, end)).dt,
                     fine = automatic_inertia(thin(40, start, end)).dt,
                     finest = automatic_inertia(thin(80, start, end)).dt;
        EXPECT_NEAR(coarse / fine, 2, 0.04); // J' of l^2, and steps of l
        EXPECT_NEAR(fine / finest, 2, 0.08); // less r^2/l^2
    }
}

TEST(AutomaticInertia, WithElementsKeepsTheRod) {
    RodSpec spec = thin(9, EndKind::clamped, EndKind::free);
    spec.section.profile = {9, 8, 7, 6, 5, 4, 3, 2, 1};
    spec.shape.length_profile = {1, 1, 1, 1, 1, 1, 1, 1, 2};
    spec.hold.nodes = {0, -1};
    spec.hold.elements = {0, 1, 2};
    const RodSpec more = with_elements(spec, 18);
    const auto& lengths = more.shape.length_profile;
    EXPECT_NEAR(std::accumulate(lengths.begin(), lengths.end(), 0.0), 1, 1e-12);
    EXPECT_NEAR(lengths.back(), 2 * lengths.front(), 1e-12);
    EXPECT_EQ(more.hold.nodes, (std::vector<long>{0, 18}));
    EXPECT_EQ(more.hold.elements, (std::vector<long>{0, 1, 2, 3, 4, 5}));
    EXPECT_NEAR(more.section.profile.front(), 9.25, 1e-12);
    EXPECT_EQ(with_elements(spec, 9).section.profile, spec.section.profile);
}

} // namespace
} // namespace skein
