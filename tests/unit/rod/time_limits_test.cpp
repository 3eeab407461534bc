// The closed-form limit is sharp: an undamped rod runs at 0.98 of it and diverges at 1.05.
#include "diagnostics/observables.hpp"
#include "mechanics/elastic.hpp"
#include "mechanics/gyration.hpp"
#include "mechanics/kick.hpp"
#include "mechanics/present_eigenvalues.hpp"
#include "rod/time_limits.hpp"
#include "support/rods_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

void take_steps(const RodGroup& group, const RodTile<1>& tile, SlotLoad<1>* load, double dt, int steps) {
    const KickPass<KickKind::undamped, 1> kick({KickConstants(group, {}, dt)});
    with_energy_law(group.law(), [&]<class L>(L) {
        const ElasticPass<L, 1> elastic(ends_of(group));
        for (int i = 0; i < steps; ++i) {
            drift<CircularGyration>(tile, i == 0 ? 0.5 * dt : dt);
            elastic.run(tile, load, Step{});
            kick.run(tile, load, Step{});
        }
    });
}

/// Energy of a barely shaken undamped rod after so many steps, over that at the start.
double energy_growth(const RodGroup& group, double dt, int steps) {
    std::vector<Slot<1>> state = test::shaken_state(group, 1e-9 * group.element[0].rest_length, 1e-9, 0);
    for (Slot<1>& s : state) {
        set_lane(s.velocity, 0, Vec3d{0, 0, 0});
        set_lane(s.spin, 0, Vec3d{0, 0, 0});
    }
    // Held nodes must start in place.
    std::vector<Slot<1>> rest(state.size());
    group.start_state(0, rest);
    state[0].position = rest[0].position;
    const double before = rod_energy(group, state).elastic();
    std::vector<SlotLoad<1>> load(state.size());
    const RodTile<1> tile = test::tile_of(group, state);
    take_steps(group, tile, load.data(), dt, steps);
    const RodEnergy u = rod_energy(group, state);
    return (u.translation + u.rotation + u.elastic()) / before;
}

TEST(TimeLimits, AreSharp) {
    for (const double aspect : {5.0, 31.0, 100.0})
        for (const long n : {8L, 25L, 50L})
            for (const EndKind start : {EndKind::free, EndKind::clamped}) {
                RodSpec spec = test::simple_rod(n);
                spec.section.radius = 0.5 / aspect;
                spec.start = start;
                const RodGroup group(spec, 0, 0, "");
                const double limit = time_limits(group).front().dt;
                EXPECT_LT(energy_growth(group, 0.98 * limit, 3000), 50) << "aspect " << aspect << ", n " << n;
                EXPECT_FALSE(energy_growth(group, 1.05 * limit, 3000) < 1e6) << "aspect " << aspect << ", n " << n;
            }
}

std::vector<std::pair<Law, double>> laws_and_strains(std::initializer_list<double> strains) {
    std::vector<std::pair<Law, double>> all;
    for (const Law law : test::energy_laws())
        for (const double strain : strains) all.emplace_back(law, strain);
    return all;
}

TEST(TimeLimits, AreSharpForStretchedRestShapes) {
    for (const auto& [law, strain] : laws_and_strains({-0.4, -0.2, 0.5}))
        for (const double aspect : {5.0, 50.0})
            for (const EndKind start : {EndKind::free, EndKind::clamped}) {
                RodSpec spec = test::simple_rod(20);
                spec.material.law = law;
                spec.section.radius = 0.5 / aspect;
                spec.shape.rest_strain.z = strain;
                spec.start = start;
                const RodGroup group(spec, 0, 0, "");
                const double limit = time_limits(group).front().dt;
                EXPECT_LT(energy_growth(group, 0.98 * limit, 3000), 50)
                    << test::name_of(law) << ", strain " << strain << ", aspect " << aspect;
                EXPECT_FALSE(energy_growth(group, 1.05 * limit, 3000) < 1e6)
                    << test::name_of(law) << ", strain " << strain << ", aspect " << aspect;
            }
}

TEST(TimeLimits, OfAStraightUniformRodAreTheTextbookOnes) {
    const RodSpec spec = test::simple_rod(10);
    const RodGroup group(spec, 0, 0, "");
    for (const TimeLimit& limit : time_limits(group)) {
        if (limit.mode == "axial") {
            EXPECT_NEAR(limit.dt, 0.1 * std::sqrt(1000 / 1e6), 1e-15);
        }
        if (limit.mode == "twist") {
            EXPECT_NEAR(limit.dt, 0.1 * std::sqrt(1000 / (1e6 / 3)), 1e-15);
        }
    }
}

TEST(TimeLimits, NameTheThinEndOfATaperedRod) {
    RodSpec spec = test::simple_rod(10);
    spec.section.taper = 0.2;
    const TimeLimit limit = time_limits(RodGroup(spec, 0, 0, "")).front();
    EXPECT_EQ(limit.element, 9);
    EXPECT_NE(limit.mode.find("shear-rotation"), std::string_view::npos);
}

// At rest the bound at present strains is that of the rest shape, mode by mode.
TEST(PresentLimits, AtRestAreThoseOfTheRestShape) {
    for (const bool closed : {false, true})
        for (const Law law : test::energy_laws())
            for (const double strain : {0.0, -0.2}) {
                RodSpec spec = test::simple_rod(9);
                spec.material.law = law;
                spec.shape.rest_strain.z = closed ? 0 : strain;
                spec.shape.closed = closed;
                if (!closed)
                    spec.section = {.kind = SectionKind::elliptic, .radius = 0.03, .radius_2 = 0.02, .taper = 0.5};
                if (!closed) spec.start = EndKind::clamped;
                const RodGroup group(spec, 0, 0, "");
                std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
                group.start_state(0, state);
                double most[4] = {};
                present_eigenvalues(test::tile_of(group, state), [&](int, const PresentEigenvalues<Pack<1>>& l) {
                    const double all[] = {l.axial[0], l.about_d1[0], l.about_d2[0], l.twist[0]};
                    for (int i = 0; i < 4; ++i) most[i] = std::max(most[i], all[i]);
                });
                for (const TimeLimit& limit : time_limits(group))
                    for (int i = 0; i < 4; ++i)
                        if (limit.mode == limiting_modes[i]) {
                            // A ring's frames turn from cell to cell by 2 pi/9: phi/2 over its sine, squared, on
                            // bending; its chords are straight.
                            EXPECT_NEAR(2 / std::sqrt(most[i]) / limit.dt, 1, closed ? 0.03 : 1e-9)
                                << limit.mode << " " << strain << closed;
                        }
            }
}

/// Kinetic energy that a barely shaken rod, clamped at both ends at `e` times its length, has after so many steps; over
/// the energy of the shaking.
double growth_between_walls(RodSpec spec, double e, double share, int steps) {
    spec.start = spec.end = EndKind::clamped;
    const RodGroup group(spec, 0, 0, "");
    std::vector<Slot<1>> state = test::shaken_state(group, 0, 1e-9, 0);
    for (std::size_t k = 0; k < state.size(); ++k) {
        set_lane(state[k].position, 0, (e * static_cast<double>(k) * group.element[0].rest_length) * Vec3d{0, 0, 1});
        set_lane(state[k].velocity, 0, Vec3d{0, 0, 0});
        set_lane(state[k].spin, 0, Vec3d{0, 0, 0});
    }
    const RodTile<1> tile = test::tile_of(group, state);
    const double dt = share * 2 / std::sqrt(largest_eigenvalue(tile)[0]);
    std::vector<SlotLoad<1>> load(state.size());
    const double scale = group.element[0].stiffness.x * 1e-18;
    take_steps(group, tile, load.data(), dt, steps);
    const RodEnergy u = rod_energy(group, state);
    return (u.translation + u.rotation) / scale;
}

TEST(PresentLimits, AreSharpBetweenWalls) {
    for (const Law law : {Law::incompressible, Law::neo_hookean})
        for (const auto& [e, radius] : {std::pair{0.85, 0.3},
                                        {0.95, 0.15},
                                        {1.2, 0.01},
                                        {1.2, 0.1},
                                        {1.6, 0.05}}) { // thick where it might buckle
            RodSpec spec = test::simple_rod(10);
            spec.material.law = law;
            spec.section.radius = radius;
            EXPECT_LT(growth_between_walls(spec, e, 0.98, 3000), 1e3)
                << test::name_of(law) << " " << e << " " << radius;
            EXPECT_FALSE(growth_between_walls(spec, e, 1.05, 3000) < 1e6)
                << test::name_of(law) << " " << e << " " << radius;
        }
}

TEST(TensionLimit, ExistsOnlyForSmallShearModulus) {
    RodSpec spec = test::simple_rod();
    EXPECT_TRUE(std::isinf(tension_limit(RodGroup(spec, 0, 0, ""))));
    spec.material.shear_modulus = 1e6 / 5; // measured: stable at e = 1.34, flips at 1.37
    EXPECT_NEAR(tension_limit(RodGroup(spec, 0, 0, "")), 1.3531, 1e-4);
    spec.shape.rest_strain.z = -0.1; // 1 - 4 alpha G e0/E = 1 - 4 (27/28) (1/5) 0.9
    EXPECT_NEAR(tension_limit(RodGroup(spec, 0, 0, "")), 1.1591, 1e-4);
}

} // namespace
} // namespace skein
