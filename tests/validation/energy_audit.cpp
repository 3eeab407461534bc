// The energy audit (theory.md section 16): kinetic and elastic energy, less the work of loads and walls, plus
// dissipation, stay as they were, to the second order in the step.
//   walls    rods whose clamped ends are shifted and turned by ramps; the wall's work is all there is
//   driven   cilia in a turning field under damping; ramped walls, gravity and damping together
//   twins    sums with closed forms, and the same bits at every width
#include "diagnostics/energy_audit.hpp"
#include "loads/gravity.hpp"
#include "loads/magnetic_field.hpp"
#include "scene/make_groups.hpp"
#include "validation/study.hpp"

namespace skein {
namespace {

/// Audit at the end of a scene at N steps, as the defect's share of the turnover: what loads and walls put in or took
/// out at most.
struct Balance {
    double dt = 0, defect = 0, turnover = 0;
    EnergyAudit end;
};

Balance balance(SceneSpec scene, double dt, test::Cost& cost, int lanes = 8) {
    scene.time.dt = dt;
    scene.output.audit = true;
    test::Stage stage(scene, lanes);
    const auto audit = [&] {
        EnergyAudit sum;
        for (std::size_t i = 0; i < stage.rods->local().size(); ++i) {
            const EnergyAudit a = audit_rod(stage.groups, *stage.rods, i, stage.clock.time(), stage.clock.lag());
            sum = {sum.energy + a.energy, sum.loads + a.loads, sum.walls + a.walls, sum.dissipated + a.dissipated};
        }
        return sum;
    };
    const double start = audit().energy;
    Balance b{.dt = stage.plan.dt};
    for (int part = 1; part <= 16; ++part) {
        test::advance(stage, part * stage.plan.steps / 16, cost);
        b.end = audit();
        b.turnover = std::max({b.turnover, std::abs(b.end.loads), std::abs(b.end.walls), b.end.dissipated});
        b.defect = std::max(b.defect, std::abs(b.end.defect(start)));
    }
    return b;
}

/// Largest defect at `steps` steps, at twice and four times as many: below `bar` of the turnover at the finest,
/// ratios 4.0 +- 0.4.
void study(test::ErrorTable& table, const std::string& name, const SceneSpec& scene, long steps, double bar) {
    for (const long refinement : {1, 2, 4}) {
        test::Cost cost;
        const Balance b = balance(scene, scene.time.duration / static_cast<double>(steps * refinement), cost);
        const double error = b.defect / b.turnover,
                     order = table.add(name, scene.rods[0].shape.elements, b.dt, error, cost);
        if (refinement > 1) {
            EXPECT_NEAR(std::exp2(order), 4.0, 0.4) << name;
        }
        if (refinement == 4) {
            EXPECT_LE(error, bar) << name;
        }
    }
}

/// Ramps of 0.4 s, in a rod whose slowest mode takes 0.6 s.
SceneSpec ramped(EndKind kind, Law law, bool both) {
    SceneSpec scene;
    RodSpec rod = test::simple_rod(12);
    rod.material.law = law;
    rod.start = both ? kind : EndKind::free;
    rod.end = kind;
    rod.end_motion = {.times = {0, 0.4},
                      .translation = {{0, 0, 0}, {0.1, 0.05, -0.08}},
                      .rotation = {{0, 0, 0}, {0.9, -0.3, 1.1}},
                      .smooth = true};
    if (both)
        rod.start_motion = {.times = {0, 0.4},
                            .translation = {{0, 0, 0}, {-0.05, 0, 0.03}},
                            .rotation = {{0, 0, 0}, {-0.5, 0.4, -0.6}},
                            .smooth = true};
    scene.rods = {rod};
    scene.time.duration = 0.4;
    return scene;
}

TEST(EnergyAudit, RampedWallsDoTheWorkThatTheRodGains) {
    test::ErrorTable table("energy_audit_walls");
    for (const bool both : {false, true})
        for (const Law law : test::energy_laws())
            for (const EndKind kind : {EndKind::clamped, EndKind::clamped_frozen})
                study(table,
                      std::string(both ? "two walls, " : "one wall, ") + test::name_of(law) + ", " +
                          (kind == EndKind::clamped ? "half cells" : "frozen"),
                      ramped(kind, law, both), 2000, 1e-6);
}

// Ends that slide where they are not moved: the wall does the work of the directions that it holds.
TEST(EnergyAudit, WallsThatLetEndsSlideDoTheWorkThatTheRodGains) {
    test::ErrorTable table("energy_audit_sliding");
    for (const EndKind kind : {EndKind::clamped, EndKind::clamped_frozen}) {
        SceneSpec scene = ramped(kind, Law::incompressible, true);
        RodSpec& rod = scene.rods[0];
        rod.end_free = "z";
        rod.end_motion.translation.back().z = 0;
        rod.start_free = "xy";
        rod.start_motion.translation.back().x = 0;
        study(table, kind == EndKind::clamped ? "half cells" : "frozen", scene, 2000, 1e-6);
        test::Stage stage(scene, 1);
        const auto before = stage.state(0);
        stage.advance(stage.plan.steps);
        const auto after = stage.state(0);
        const Vec3d end = lane(after.back().position, 0) - lane(before.back().position, 0),
                    start = lane(after.front().position, 0) - lane(before.front().position, 0);
        EXPECT_NEAR(end.x, 0.1, 1e-6) << "brought up to the time of the rates: an error of second order";
        EXPECT_NEAR(end.y, 0.05, 1e-6);
        EXPECT_NEAR(start.z, 0.03, 1e-6);
        EXPECT_GT(std::min({std::abs(end.z), std::abs(start.x), std::abs(start.y)}), 1e-3) << "slides";
    }
}

TEST(EnergyAudit, DrivenDampedCiliaBalance) {
    test::ErrorTable table("energy_audit_driven");
    for (const DampingKind kind : {DampingKind::uniform, DampingKind::legacy}) {
        SceneSpec scene = test::cilia_scene(2);
        scene.rods[0].magnetisation.strength = 5781.25;
        scene.damping[0].damping.kind = kind;
        scene.loads[0].load.as<MagneticField>().ramp = {3.6};
        study(table, kind == DampingKind::uniform ? "cilia, uniform" : "cilia, legacy", scene, 8192, 1e-6);
    }
    SceneSpec scene = ramped(EndKind::clamped, Law::incompressible, true);
    scene.loads = {{.load = Gravity{}}};
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 5}}};
    study(table, "walls and gravity, uniform", scene, 2000, 1e-6);
}

// Filters count as dissipation; a step of four stages has four kicks in its energy budget, two of them backwards.
TEST(EnergyAudit, ClosesWithFiltersAndAtFourthOrder) {
    test::ErrorTable table("energy_audit_schemes");
    for (const bool filtered : {false, true}) {
        SceneSpec scene = ramped(EndKind::clamped, Law::incompressible, true);
        scene.loads = {{.load = Gravity{}}};
        scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 5}}};
        if (filtered) scene.damping.push_back({.damping = {.kind = DampingKind::laplacian, .rate = 50, .order = 3}});
        else scene.time.integrator = Integrator::pefrl;
        test::Cost cost;
        const Balance b = balance(scene, scene.time.duration / 8000, cost);
        const double error = b.defect / b.turnover;
        table.add(filtered ? "verlet, filtered" : "pefrl", 12, b.dt, error, cost);
        EXPECT_LE(error, 1e-6) << filtered;
        EXPECT_GT(b.end.dissipated, 0);
    }
}

TEST(EnergyAudit, SumsMeetClosedForms) {
    // A free fall of T under damping nu: work m g^2 (T - (1 - a)/nu)/nu and dissipation the rest, a = exp(-nu T).
    SceneSpec scene;
    scene.rods = {test::simple_rod(4)};
    scene.time.duration = 0.5;
    scene.loads = {{.load = Gravity{.acceleration = {0, 0, -9.81}}}};
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 3}}};
    double mass = 0;
    const auto groups = make_groups(scene);
    for (const double m : groups[0].node_mass) mass += m;
    const double a = std::exp(-1.5), speed = 9.81 * (1 - a) / 3;
    const double work = mass * 9.81 * 9.81 * (0.5 - (1 - a) / 3) / 3, dissipated = work - 0.5 * mass * speed * speed;
    test::ErrorTable table("energy_audit_fall");
    test::Cost cost;
    for (const long steps : {512, 1024, 2048}) {
        const Balance b = balance(scene, 0.5 / static_cast<double>(steps), cost);
        const double order = table.add("work", 4, b.dt, std::abs(b.end.loads - work) / work);
        const double order_d = table.add("dissipated", 4, b.dt, std::abs(b.end.dissipated - dissipated) / dissipated);
        if (steps > 512) {
            EXPECT_NEAR(std::exp2(order), 4.0, 0.4);
            EXPECT_NEAR(std::exp2(order_d), 4.0, 0.4);
        }
        EXPECT_LT(b.defect, 1e-12 * work);
    }
}

TEST(EnergyAudit, HasTheSameBitsAtEveryWidthAndLeavesTheRunAlone) {
    SceneSpec scene = test::cilia_scene(5, 8);
    scene.time.duration = 0.5;
    test::Cost cost;
    const double dt = 0.5 / 128;
    const Balance one = balance(scene, dt, cost, 1);
    for (const int lanes : test::other_lanes()) {
        const Balance wide = balance(scene, dt, cost, lanes);
        EXPECT_EQ(wide.end.energy, one.end.energy) << lanes;
        EXPECT_EQ(wide.end.loads, one.end.loads) << lanes;
        EXPECT_EQ(wide.end.dissipated, one.end.dissipated) << lanes;
    }
    scene.time.dt = dt;
    test::Stage plain(scene);
    scene.output.audit = true;
    test::Stage audited(scene);
    plain.advance(128);
    audited.advance(128);
    EXPECT_EQ(plain.rods->digest(), audited.rods->digest());
    EXPECT_LT(plain.rods->bytes(), audited.rods->bytes());
    EXPECT_EQ(plain.rods->budget(0).loads, 0);
    EXPECT_GT(audited.rods->budget(0).loads, 0);
}

} // namespace
} // namespace skein
