// Every load against its formula, written out plainly.
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

struct Loaded {
    std::vector<Slot<1>> state;
    std::vector<SlotLoad<1>> load;

    Vec3d force(std::size_t i) const { return lane(load[i].force, 0); }
    Vec3d couple(std::size_t k) const { return lane(load[k].couple, 0); }
    Quaterniond director(std::size_t k) const { return lane(state[k].director, 0); }
    Vec3d total_force() const {
        Vec3d sum{0, 0, 0};
        for (std::size_t i = 0; i < load.size(); ++i) sum += force(i);
        return sum;
    }
};

/// What one load adds to a shaken rod at time t.
Loaded apply(const Load& load, const RodGroup& group, double t) {
    Loaded out{test::shaken_state(group, 0.01, 0.4, 1), {}};
    out.load.assign(out.state.size(), SlotLoad<1>{});
    const RodTile<1> tile = test::tile_of(group, out.state);
    const auto pass = make_pass<1>(load, group);
    pass->bind(tile);
    const Step step{.index = 1, .dt = 1, .drift = 1, .time = t, .slot = 0};
    pass->prepare(std::span(&step, 1));
    pass->run(tile, out.load.data(), step);
    return out;
}

void expect_near(const Vec3d& a, const Vec3d& b, double tolerance) {
    EXPECT_LT(norm(a - b), tolerance) << a.x << " " << a.y << " " << a.z;
}

TEST(Loads, GravityIsTheWeightOfEveryNode) {
    const RodGroup group(test::crooked_rod(), 0, 0, "");
    const Loaded r = apply(Gravity{{0, 1, -9.81}}, group, 0);
    for (std::size_t i = 0; i < r.load.size(); ++i)
        expect_near(r.force(i), group.node_mass[i] * Vec3d{0, 1, -9.81}, 1e-14);
}

TEST(Loads, UniformForceSharesItsTotalByLength) {
    const RodGroup group(test::simple_rod(4), 0, 0, "");
    const Loaded r = apply(UniformForce{.force = {8, 0, 0}, .ramp = {2}}, group, 1);
    expect_near(r.total_force(), {4, 0, 0}, 1e-14);
    EXPECT_NEAR(r.force(0).x, 0.5, 1e-15);
    EXPECT_NEAR(r.force(2).x, 1.0, 1e-15);
}

TEST(Loads, UniformCoupleIsFixedInTheLab) {
    const RodGroup group(test::crooked_rod(), 0, 0, "");
    const Loaded r = apply(UniformCouple{.couple = {1, 2, 3}}, group, 0);
    Vec3d total{0, 0, 0};
    for (std::size_t k = 0; k + 1 < r.load.size(); ++k) total += transpose_times(r.director(k), r.couple(k));
    expect_near(total, {1, 2, 3}, 1e-13);
}

TEST(Loads, EndForcesRiseWithTheirRamp) {
    const RodGroup group(test::simple_rod(4), 0, 0, "");
    for (const auto& [t, r] : {std::pair{0.0, 0.0}, std::pair{0.5, 0.25}, std::pair{2.0, 1.0}, std::pair{9.0, 1.0}}) {
        const Loaded l = apply(EndForce{.start = {0, 0, 3}, .end = {-4, 0, 0}, .ramp = {2}}, group, t);
        expect_near(l.force(0), {0, 0, 3 * r}, 1e-15);
        expect_near(l.force(4), {-4 * r, 0, 0}, 1e-15);
        expect_near(l.force(2), {0, 0, 0}, 1e-15);
    }
}

TEST(Loads, MagneticFieldTurnsTheMomentTowardsItself) {
    for (const bool straight : {true, false}) {
        RodSpec spec = straight ? test::simple_rod() : test::crooked_rod();
        spec.magnetisation = {.pattern = MagnetisationPattern::uniform, .strength = 5e3, .direction = {1, 2, 2}};
        const RodGroup group(spec, 0, 0, "");
        const MagneticField field{.constant = {0, 8e-4, 0}, .rotating = 0.08, .period = 72, .ramp = {10}};
        const double t = 5, angle = 2 * std::numbers::pi * t / 72;
        const Vec3d b = 0.5 * Vec3d{0.08 * std::sin(angle), 8e-4, 0.08 * std::cos(angle)};
        const Loaded r = apply(field, group, t);
        for (std::size_t k = 0; k + 1 < r.load.size(); ++k) {
            const Vec3d moment =
                5e3 * group.element[k].volume * (group.start_directors()[k] * ((1.0 / 3) * Vec3d{1, 2, 2}));
            expect_near(r.couple(k), cross(moment, r.director(k) * b), 1e-15 + 1e-13 * norm(moment) * norm(b));
        }
    }
}

TEST(Loads, MagnetisationWavesAreUnitVectorsAndMirrorWithTheWavelength) {
    RodSpec spec = test::simple_rod();
    spec.placement = {.kind = PlacementKind::lattice, .counts = {5, 4}, .spacing = {0.7, 0.9}};
    spec.magnetisation = {
        .pattern = MagnetisationPattern::wave_xy, .strength = 1, .wavelength_x = 3, .wavelength_y = 5};
    const RodGroup group(spec, 0, 0, "");
    for (std::int64_t i = 0; i < group.count(); ++i) EXPECT_NEAR(norm(group.magnetisation(i)), 1, 1e-9);

    spec.magnetisation = {.pattern = MagnetisationPattern::wave_x, .strength = 1, .wavelength_x = 3};
    RodSpec mirrored = spec;
    mirrored.magnetisation.wavelength_x = -3;
    const RodGroup one(spec, 0, 0, ""), other(mirrored, 0, 0, "");
    EXPECT_NEAR(one.magnetisation(0).z, -1, 1e-15);
    EXPECT_NEAR(one.magnetisation(1).x, std::sin(std::numbers::pi + 2 * std::numbers::pi * 0.7 / 3), 1e-15);
    EXPECT_NEAR(other.magnetisation(1).x, -one.magnetisation(1).x, 1e-15);
}

TEST(Loads, MuscleWaveIsInternal) {
    const RodGroup group(test::simple_rod(6), 0, 0, "");
    const MuscleWave wave{.amplitude = 0.3,
                          .profile = {1, 2, 3, 2, 1},
                          .period = 2,
                          .wavelength = 0.8,
                          .phase = 0.4,
                          .direction = {0, 0, 1},
                          .ramp = {4}};
    const double t = 1.3;
    const Loaded r = apply(wave, group, t);
    Vec3d total{0, 0, 0};
    for (std::size_t k = 0; k < 6; ++k) total += transpose_times(r.director(k), r.couple(k));
    expect_near(total, {0, 0, 0}, 1e-15);
    const auto at = [&](int j) {
        const double s = j / 6.0;
        return t / 4 * 0.3 * nth(wave.profile, j - 1) *
               std::sin(std::numbers::pi * t - 2 * std::numbers::pi * s / 0.8 + 0.4);
    };
    expect_near(r.couple(5), r.director(5) * Vec3d{0, 0, at(5)}, 1e-15);
    expect_near(r.couple(2), r.director(2) * Vec3d{0, 0, at(2) - at(3)}, 1e-15);
}

TEST(Loads, AmplitudesOfMusclesAtPlacesFitAnyElements) {
    // Linear from (0.2, 1) to (0.6, 3), and as there before and beyond.
    MuscleWave through{.amplitude = 0.3, .profile = {1, 3}, .profile_at = {0.2, 0.6}, .period = 2, .wavelength = 0.8};
    for (const int n : {4, 6, 11}) {
        const RodGroup group(test::simple_rod(n), 0, 0, "");
        MuscleWave sampled = through;
        sampled.profile_at.clear();
        sampled.profile.clear();
        for (int j = 1; j < n; ++j)
            sampled.profile.push_back(std::clamp(1 + 2 * (j / double(n) - 0.2) / 0.4, 1.0, 3.0));
        const Loaded one = apply(through, group, 1.3), other = apply(sampled, group, 1.3);
        for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k)
            expect_near(one.couple(k), other.couple(k), 1e-15);
    }
}

} // namespace
} // namespace skein
