// Relaxation (theory.md section 21) of clamped rods of 50 elements with L/r from 50 to 5000, and of others that are
// held or loaded in other ways: steps until the tip stays within 1e-6 of where it ends, over the deflection; and what
// it ends at, against closed forms and boundary-value problems, which the elements miss by their own error.
#include "loads/end_force.hpp"
#include "loads/gravity.hpp"
#include "skein/core/index.hpp"
#include "support/large_rotation.hpp"
#include "validation/study.hpp"

#include <algorithm>
#include <numbers>
#include <string_view>
#include <vector>

namespace skein {
namespace {

constexpr std::int64_t steps = 4000, most_steps = 200000;
static_assert(steps <= most_steps);

SceneSpec relaxing(RodSpec rod, std::vector<LoadSpec> loads) {
    SceneSpec scene;
    scene.time.duration = most_steps;
    scene.time.relax = true;
    scene.rods = {std::move(rod)};
    scene.loads = std::move(loads);
    return scene;
}

RodSpec slender_rod(double slenderness, long n = 50) {
    RodSpec rod = test::clamped_unit_rod(n, 1 / slenderness);
    rod.material.youngs_modulus = 1e9;
    return rod;
}

double bending_of(const RodSpec& rod) {
    const double r = rod.section.radius;
    return rod.material.youngs_modulus * 0.25 * std::numbers::pi * r * r * r * r;
}

Vec3d node(const test::Stage& stage, int i) { return lane(nth(stage.state(0), i).position, 0); }

struct Way {
    Vec3d begin, end;
    std::int64_t steps; ///< from which on the node stays within 1e-6 of its way's length
};

Way way_of(const SceneSpec& scene, int watched, int lanes = 1, Mapping mapping = Mapping::automatic) {
    test::Stage stage(scene, lanes, 1, mapping);
    std::vector<Vec3d> at{node(stage, watched)};
    while (stage.clock.done() < steps) {
        stage.advance(stage.clock.done() + 1);
        at.push_back(node(stage, watched));
    }
    const Vec3d end = at.back();
    const double reach = 1e-6 * norm(end - at.front());
    const auto last = std::find_if(at.rbegin(), at.rend(), [&](const Vec3d& x) { return !(norm(x - end) <= reach); });
    return {at.front(), end, at.rend() - last};
}

/// Deflection of the elastica, and how far its tip has come nearer, under a dead load P L^2/(EI) across it.
std::pair<double, double> elastica(double load) {
    constexpr int parts = 4000;
    const double h = 1.0 / parts;
    double across = 0, along = 0;
    const auto slope_at_end = [&](double curvature) { // of the wall
        double angle = 0, kappa = curvature;
        across = along = 0;
        for (int i = 0; i < parts; ++i) { // theta'' = -load cos theta, midpoint rule twice as fine
            const double middle = angle + 0.5 * h * kappa, kappa_middle = kappa - 0.5 * h * load * std::cos(angle);
            across += h * std::sin(middle);
            along += h * std::cos(middle);
            angle += h * kappa_middle;
            kappa -= h * load * std::cos(middle);
        }
        return kappa;
    };
    double low = 0, high = load;
    for (int i = 0; i < 60; ++i) (slope_at_end(0.5 * (low + high)) < 0 ? low : high) = 0.5 * (low + high);
    slope_at_end(0.5 * (low + high));
    return {across, 1 - along};
}

TEST(Relaxation, SlenderRodsSettleInAFewHundredSteps) {
    for (const double slenderness : {50.0, 500.0, 5000.0})
        for (const double load : {0.01, 1.0, 10.0}) {
            const RodSpec rod = slender_rod(slenderness);
            const double force = load * bending_of(rod);
            const Way way = way_of(relaxing(rod, {{.load = EndForce{.end = {force, 0, 0}}}}), 50);
            const Vec3d moved = way.end - way.begin;
            std::printf("relaxation: L/r %g, P L^2/EI %g: within 1e-6 after %lld steps, tip (%.9f, %.9f)", slenderness,
                        load, static_cast<long long>(way.steps), moved.x, moved.z);
            EXPECT_LE(way.steps, 600) << slenderness << ", " << load;
            const double shear =
                27.0 / 28 / 3 * rod.material.youngs_modulus * std::numbers::pi / (slenderness * slenderness);
            const double exact = load < 0.1 ? load / 3 + force / shear : elastica(load).first;
            std::printf(", error over deflection %.2e\n", moved.x / exact - 1);
            if (load < 0.1) {
                EXPECT_NEAR(moved.x / exact, 1, 3e-4) << slenderness; // and (P L^2/EI)^2 of the large deflection
            } else if (slenderness > 1000) {
                EXPECT_NEAR(moved.x / exact, 1, 3e-4) << load;
                EXPECT_NEAR(-moved.z / elastica(load).second, 1, 6e-4) << load;
            }
        }
}

TEST(Relaxation, EndsWhereBoundaryValueProblemsDo) {
    using namespace test::large_rotation;
    for (const Law law : {Law::incompressible, Law::linear})
        for (const TipLoad& load : {straight, bend}) {
            double before = 0;
            for (const long n : {20, 40}) {
                SceneSpec dynamic = test::large_rotation::scene(load, n);
                dynamic.rods[0].material.law = law;
                const Way way = way_of(relaxing(dynamic.rods[0], dynamic.loads), static_cast<int>(n));
                const double error = norm(way.end - tip(law, load));
                std::printf("relaxation: large rotation, n %ld: %lld steps, error %.3e\n", n,
                            static_cast<long long>(way.steps), error);
                EXPECT_LE(way.steps, 600);
                if (n == 40) {
                    EXPECT_NEAR(std::log2(before / error), 2, 0.1);
                }
                before = error;
            }
        }
}

/// A ring that is held at its top node and bears its own weight: changes of its diameters over w R^4/EI are pi^2/4 - 2
/// down and
/// -(2 - pi/2) across, by the energy of an inextensible circle.
TEST(Relaxation, HangingRingsMeetTheThinRing) {
    constexpr double pi = std::numbers::pi, radius = 1 / (2 * pi), load = 1e-5;
    double down_before = 0, across_before = 0;
    for (const long n : {32, 64}) {
        RodSpec ring = slender_rod(2000, n);
        ring.start = EndKind::free;
        ring.shape.closed = true;
        ring.shape.rest_curvature = {2 * pi, 0, 0};
        ring.hold.nodes = {0};
        ring.placement.tangent = {0, -1, 0};
        ring.placement.normal = Vec3d{1, 0, 0};
        const double r = ring.section.radius, weight = load * bending_of(ring) / (radius * radius * radius);
        const SceneSpec scene = relaxing(ring, {{.load = Gravity{.acceleration = {0, 0, -weight / (pi * r * r)}}}});
        test::Stage stage(scene, 4);
        const auto size = [&] {
            const int quarter = static_cast<int>(n / 4);
            return std::pair{norm(node(stage, 2 * quarter) - node(stage, 0)),
                             norm(node(stage, 3 * quarter) - node(stage, quarter))};
        };
        const auto [down, across] = size();
        stage.advance(steps);
        const double unit = load * radius, down_now = (size().first - down) / unit,
                     across_now = (size().second - across) / unit;
        const double down_off = down_now / (pi * pi / 4 - 2) - 1, across_off = across_now / -(2 - pi / 2) - 1;
        std::printf("relaxation: hanging ring, n %ld: diameters %.6f, %.6f, off by %.3e, %.3e\n", n, down_now,
                    across_now, down_off, across_off);
        if (n == 64) {
            EXPECT_NEAR(std::log2(down_before / down_off), 2, 0.1);
            EXPECT_NEAR(std::log2(across_before / across_off), 2, 0.1);
            EXPECT_LT(std::abs(down_off) + std::abs(across_off), 2e-2);
        }
        down_before = down_off;
        across_before = across_off;
    }
}

/// The twin: rods that motion and damping bring to rest.
TEST(Relaxation, EndsWhereDampedMotionDoes) {
    struct Case {
        const char* name;
        EndKind start, end;
        Vec3d rest_curvature, force;
        double weight; ///< EI/L^3
        bool strip;    ///< an elliptic, tapered section
        Law law;
    };
    const Case cases[] = {
        {"frozen", EndKind::clamped_frozen, EndKind::free, {0, 0, 0}, {2, 1, 0}, 0, false, Law::incompressible},
        {"curved", EndKind::clamped, EndKind::free, {3, 1, 2}, {1, 2, 3}, 2, false, Law::incompressible},
        {"curved, linear", EndKind::clamped, EndKind::free, {3, 1, 2}, {1, 2, 3}, 2, false, Law::linear},
        {"strip", EndKind::clamped, EndKind::free, {1, 1, 0}, {1, 0.3, -1}, 1, true, Law::incompressible},
        {"pinned arch that hangs",
         EndKind::pinned,
         EndKind::pinned,
         {3, 0, 0},
         {0, 0, 0},
         300,
         false,
         Law::incompressible},
        {"between two clamps",
         EndKind::clamped,
         EndKind::clamped,
         {0, 0, 0},
         {0, 0, 0},
         300,
         false,
         Law::incompressible},
        {"weighted ends", EndKind::clamped, EndKind::free, {0, 0, 0}, {1, 2, 3}, 2, false, Law::incompressible},
    };
    for (const Case& c : cases) {
        RodSpec rod = test::clamped_unit_rod(16, 0.05);
        rod.start = c.start;
        rod.end = c.end;
        rod.material.law = c.law;
        rod.shape.rest_curvature = c.rest_curvature;
        if (c.strip) rod.section = {.kind = SectionKind::elliptic, .radius = 0.05, .radius_2 = 0.02, .taper = 0.7};
        if (std::string_view(c.name) == "weighted ends") rod.shape.end_weights = EndWeights::gregory;
        const double bending = bending_of(test::clamped_unit_rod(16, 0.02 * (c.strip ? 1.5 : 2.5)));
        const double mass = rod.material.density * std::numbers::pi * 0.05 * (c.strip ? 0.02 : 0.05);
        std::vector<LoadSpec> loads;
        if (norm(c.force) > 0) loads.push_back({.load = EndForce{.end = bending * c.force}});
        if (c.weight > 0) loads.push_back({.load = Gravity{.acceleration = {0, c.weight * bending / mass, 0}}});

        SceneSpec dynamic = test::coming_to_rest(rod, (c.strip ? 0.2 : 0.5) * test::cantilever_frequency(rod), loads);
        test::Stage twin(dynamic, 1), stage(relaxing(rod, loads), 4);
        twin.advance(twin.plan.steps);
        stage.advance(steps);
        double apart = 0, moved = 0;
        const auto start = test::Stage(dynamic, 1).state(0), one = twin.state(0), other = stage.state(0);
        for (std::size_t i = 0; i < one.size(); ++i) {
            apart = std::max(apart, norm(lane(one[i].position, 0) - lane(other[i].position, 0)));
            moved = std::max(moved, norm(lane(one[i].position, 0) - lane(start[i].position, 0)));
        }
        std::printf("relaxation: %s: moved by %.3g, apart from its twin by %.2e\n", c.name, moved, apart);
        EXPECT_GT(moved, 1e-2) << c.name;
        EXPECT_LT(apart, 1e-9) << c.name;
    }
}

/// Rods that would lie along lie across, as the band is solved along whole rods.
TEST(Relaxation, BitsDoNotDependOnLanesOrMapping) {
    RodSpec rod = test::clamped_unit_rod(12, 0.02);
    rod.placement = {.kind = PlacementKind::line, .counts = {5}, .spacing = {1.0}};
    const SceneSpec scene = relaxing(rod, {{.load = EndForce{.end = {bending_of(rod), 0, 0}}}});
    std::vector<std::uint64_t> digests;
    for (const int lanes : test::built_lanes())
        for (const Mapping mapping : {Mapping::automatic, Mapping::across, Mapping::along}) {
            test::Stage stage(scene, lanes, lanes > 4 ? 2 : 1, mapping);
            stage.advance(40, lanes > 4 ? 1 : 64);
            digests.push_back(stage.rods->digest());
            EXPECT_EQ(digests.back(), digests.front()) << lanes << " lanes";
        }
}

/// A column pressed beyond its buckling load finds the shape that it has then.
TEST(Relaxation, ColumnsBuckle) {
    const RodSpec rod = slender_rod(500, 40);
    const double euler = std::numbers::pi * std::numbers::pi / 4 * bending_of(rod);
    for (const double share : {1.02, 1.5}) {
        const Way way = way_of(relaxing(rod, {{.load = EndForce{.end = {1e-4 * euler, 0, -share * euler}}}}), 40);
        std::printf("relaxation: column at %g of its load: %lld steps, tip at (%.6f, %.6f)\n", share,
                    static_cast<long long>(way.steps), way.end.x, way.end.z);
        EXPECT_LE(way.steps, 3000);
        EXPECT_GT(way.end.x, 0.1);
    }
}

} // namespace
} // namespace skein
