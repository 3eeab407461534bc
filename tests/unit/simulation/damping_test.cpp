// What every kind of damping must do, on rods of every shape and ends: take energy in every step, at any step, converge
// with the square of the step, and keep the momentum that it says it keeps. theory.md (22)-(24), (41)
#include "diagnostics/energy_audit.hpp"
#include "scene/make_groups.hpp"
#include "skein/core/index.hpp"
#include "support/dampers.hpp"
#include "support/energy.hpp"
#include "support/scenes_for_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace skein {
namespace {

enum class Form { straight, elliptic, tapered, crooked, ring };

RodSpec rod_of(Form form, EndKind start, EndKind end) {
    RodSpec rod = form == Form::crooked ? test::crooked_rod(8) : test::simple_rod(8);
    if (form == Form::elliptic) rod.section = {.kind = SectionKind::elliptic, .radius = 0.03, .radius_2 = 0.02};
    if (form == Form::tapered) rod.section.taper = 0.3;
    if (form == Form::ring) rod.shape.closed = true;
    else rod.shape.start_curvature = Vec3d{0.8, -0.5, 0.6};
    rod.start = start;
    rod.end = end;
    return rod;
}

struct Case {
    DampingKind damper;
    Form form;
    EndKind start;
    double share; ///< of the limit of the step
    std::string start_free = {};
    EndKind end = EndKind::free;
};

std::vector<Case> all_cases() {
    std::vector<Case> cases;
    for (const DampingKind damper : test::all_dampers())
        for (const double share : {0.15, 0.5, 0.855}) {
            for (const Form form : {Form::straight, Form::elliptic, Form::tapered, Form::crooked})
                for (const EndKind start : {EndKind::free, EndKind::pinned, EndKind::clamped, EndKind::clamped_frozen})
                    cases.push_back({damper, form, start, share});
            for (const EndKind start : {EndKind::pinned, EndKind::clamped, EndKind::clamped_frozen})
                cases.push_back({damper, Form::crooked, start, share, "xz"});
            cases.push_back({damper, Form::ring, EndKind::free, share});
        }
    for (const DampingKind damper : test::all_dampers())
        for (std::size_t start = 0; start < std::size(end_names); ++start)
            for (std::size_t end = 1; end < std::size(end_names); ++end) // free ones are above
                for (const std::string start_free : {"", "x", "yz"}) {
                    const auto kind = static_cast<EndKind>(start);
                    if (start_free.empty() || kind != EndKind::free)
                        cases.push_back({damper, Form::crooked, kind, 0.5, start_free, static_cast<EndKind>(end)});
                }
    return cases;
}

std::string text(const Case& c) {
    return std::string(test::name_of(c.damper)) + ", form " + std::to_string(static_cast<int>(c.form)) + ", " +
           std::string(nth(end_names, c.start)) + " [" + c.start_free + "] and " + std::string(nth(end_names, c.end)) +
           ", at " + std::to_string(c.share);
}

test::Stage stage_of(const Case& c, bool audit) {
    SceneSpec scene;
    scene.rods = {rod_of(c.form, c.start, c.end)};
    scene.rods[0].start_free = c.start_free;
    scene.time = {.duration = 100};
    scene.damping = {{.damping = test::damper(c.damper)}};
    scene.output.audit = audit;
    const auto groups = make_groups(scene);
    scene.time.dt = c.share * time_limits(groups[0]).front().dt;
    return test::Stage(scene, 1);
}

/// Every node and element jolted: motion of all wave lengths.
void shake(test::Stage& stage, double speed) {
    const RodGroup& group = stage.groups[0];
    auto state = stage.state(0);
    const auto jolt = test::shaken_state(group, 0, 0, speed, 7);
    for (int i = 0; i < static_cast<int>(state.size()); ++i) {
        const auto at = static_cast<std::size_t>(i);
        const Vec3d free = group.slides(i) ? group.free_directions(i) : Vec3d{1, 1, 1};
        if (!group.holds_node(i)) state[at].velocity += scale(broadcast<1>(free), jolt[at].velocity);
        if (i < group.elements() && !group.holds_element(i)) state[at].spin += Pack<1>(0.1) * jolt[at].spin;
    }
    if (group.closed()) state.back().velocity = state.front().velocity;
    stage.rods->import_rod(0, state);
}

double kinetic(const test::Stage& stage) {
    const RodEnergy u = rod_energy(stage.groups[0], stage.state(0));
    return u.translation + u.rotation;
}

TEST(Damping, TakesEnergyInEveryStep) {
    for (const Case& c : all_cases()) {
        test::Stage stage = stage_of(c, true);
        shake(stage, 0.05);
        double most = 0, worst = 0, before = 0, energy = kinetic(stage);
        for (int step = 1; step <= 150; ++step) {
            stage.advance(step);
            const double now = kinetic(stage), taken = stage.rods->budget(0).dissipated;
            most = std::max({most, energy, now});
            worst = std::min(worst, (taken - before) / std::max(energy, now));
            energy = now;
            before = taken;
        }
        EXPECT_GE(worst, -1e-14) << text(c);
        EXPECT_GT(before, 0) << text(c);
    }
}

/// Most that the balance lacks, as a share of what damping has taken. Rods begin bent; a ring, which begins at rest, is
/// shaken.
double unbooked(const Case& c) {
    test::Stage stage = stage_of(c, true);
    const auto audit = [&] { return audit_rod(stage.groups, *stage.rods, 0, stage.clock.time(), stage.clock.lag()); };
    if (c.form == Form::ring) shake(stage, 0.05);
    const double start = audit().energy;
    double most = 0, taken = 0;
    const auto steps = static_cast<std::int64_t>(0.02 / stage.plan.dt);
    for (int part = 1; part <= 10; ++part) {
        stage.advance(part * steps / 10);
        most = std::max(most, std::abs(audit().defect(start)));
        taken = audit().dissipated;
    }
    return most / taken;
}

// What is lacking falls with the square of the step: what was booked wrongly would stay. Ends that are moved are left
// out: the filter takes from the jump of their walls too, and books that as taken from the rod.
TEST(Damping, BooksWhatItTakes) {
    for (Case c : all_cases()) {
        if (c.share != 0.5) continue;
        c.share = 0.1;
        const double coarse = unbooked(c);
        c.share = 0.05;
        const double fine = unbooked(c);
        EXPECT_NEAR(coarse / fine, 4, 0.3) << text(c);
        EXPECT_LT(fine, 5e-3) << text(c); // 3.8e-3 where `legacy` takes little of a ring, else below 2.2e-4
    }
}

// Whatever is left, it is less than there was: damping that feeds a mode shows after many steps.
TEST(Damping, LeavesLessEnergyThanThereWas) {
    for (const Case& c : all_cases()) {
        test::Stage stage = stage_of(c, false);
        shake(stage, 0.05);
        const RodGroup& group = stage.groups[0];
        const double start = test::energy(group, stage.state(0));
        double most = 0;
        for (int part = 1; part <= 4; ++part) {
            stage.advance(part * 500);
            most = std::max(most, test::energy(group, stage.state(0)));
        }
        EXPECT_LT(most, 1.01 * start) << text(
            c); // the energy of a Verlet step goes up and down by the square of the step
        EXPECT_LT(test::energy(group, stage.state(0)), start) << text(c);
    }
}

TEST(Damping, KeepsTheMomentumThatItSaysItKeeps) {
    for (const Case& c : all_cases()) {
        if (!test::keeps_momentum(c.damper) || c.start != EndKind::free || c.end != EndKind::free) continue;
        test::Stage stage = stage_of(c, false);
        shake(stage, 0.05);
        const RodGroup& group = stage.groups[0];
        double size = 0;
        const auto start = stage.state(0);
        for (std::size_t i = 0; i < start.size(); ++i) size += group.node_mass[i] * norm(lane(start[i].velocity, 0));
        stage.advance(2000);
        EXPECT_LT(norm(test::momenta(group, stage.state(0)).linear - test::momenta(group, start).linear), 1e-12 * size)
            << text(c);
    }
}

/// A bent rod let go, after so many steps to one time.
std::vector<Slot<1>> released(const Case& c, std::int64_t steps) {
    test::Stage plan = stage_of(c, false);
    SceneSpec scene = plan.scene;
    constexpr double time = 0.05;
    scene.time.dt = time / static_cast<double>(steps);
    if (c.form == Form::ring) scene.rods[0].shape.angular_velocity = {1, 6, -4}; // a circle at rest
    test::Stage stage(scene, 1);
    stage.advance(steps);
    return stage.state(0);
}

TEST(Damping, ConvergesWithTheSquareOfTheStep) {
    for (const DampingKind damper : test::all_dampers())
        for (const auto& [form, start] : {std::pair{Form::straight, EndKind::free},
                                          {Form::crooked, EndKind::clamped},
                                          {Form::tapered, EndKind::pinned},
                                          {Form::ring, EndKind::free}}) {
            const Case c{damper, form, start, 0.5, form == Form::tapered ? "y" : ""};
            const std::int64_t steps = 24 * static_cast<std::int64_t>(0.05 / stage_of(c, false).plan.limit);
            const auto coarse = released(c, steps), middle = released(c, 2 * steps), fine = released(c, 4 * steps);
            EXPECT_NEAR(test::distance(coarse, middle) / test::distance(middle, fine), 4, 0.3) << text(c);
        }
}

} // namespace
} // namespace skein
