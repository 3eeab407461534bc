// Undamped rods in free motion, on ladders of the step at fixed n: what the step makes of energy and orientation.
#include "scene/make_groups.hpp"
#include "scenes/work_precision/cases.hpp"

#include "support/energy.hpp"
#include "support/free_rods.hpp"
#include "support/free_top.hpp"

namespace skein::bench {

namespace {

using test::Stage;

/// Largest change of energy over that of the start.
Outcome drift(SceneSpec scene, const Config& config, const Rung& rung, const std::function<void(Stage&)>& begin) {
    configure(scene, config, rung, scene.time.duration);
    Stage stage(scene, 1);
    begin(stage);
    Outcome outcome;
    outcome.value = {{test::energy_drift(stage, stage.plan.steps, 400, outcome.cost), 0, 0}};
    return finished(stage, std::move(outcome));
}

// Two elements that no force joins: elliptic tops. Rates about the axis of least inertia and d3.
constexpr double small_rate = 0.7, large_rate = 0.9, top_time = 20; // rad/s, s

SceneSpec top_scene() {
    SceneSpec scene;
    scene.rods = {test::elliptic_rod(2, 2)};
    scene.rods[0].material.youngs_modulus = 1e-30;
    return scene;
}

Outcome top(const Config& config, const Rung& rung) {
    SceneSpec scene = top_scene();
    configure(scene, config, rung, top_time);
    scene.time.duration = top_time;
    scene.time.dt = 0.4 * rung.step; // 0.46 rad; without forces no step is too long
    Stage stage(scene, 1);
    auto state = stage.state(0);
    const Vec3d spin = test::free_top(stage.groups[0].element[0].inertia, small_rate, large_rate, 0);
    for (std::size_t k = 0; k < 2; ++k) set_lane(state[k].spin, 0, spin);
    stage.rods->import_rod(0, state);
    Outcome outcome;
    test::advance(stage, stage.plan.steps, outcome.cost);
    const Mat3d q = frame(stage.state(0)[0]);
    outcome.value = {q.d1, q.d2, q.d3};
    return finished(stage, std::move(outcome));
}

std::vector<Vec3d> top_exact(Law) {
    const RodGroup group = make_groups(top_scene())[0];
    const Mat3d q = test::free_top_directors(group.element[0].inertia, small_rate, large_rate, top_time, group.frame());
    return {q.d1, q.d2, q.d3};
}

} // namespace

std::vector<Case> cases_of_energy() {
    constexpr Choices choices{.integrator = true};
    const auto ladder = [](long n, int halvings) {
        std::vector<Rung> rungs;
        for (int i = 0; i <= halvings; ++i) rungs.push_back({n, std::exp2(-i)});
        return rungs;
    };
    const auto kept = [](Law) { return std::vector<Vec3d>{{0, 0, 0}}; };
    const auto free_rod = [](const Config& config, const Rung& rung) {
        return drift(test::flying_rod(false, 4), config, rung, [](Stage&) {});
    };
    const auto butterfly = [](const Config& config, const Rung& rung) {
        return drift(test::butterfly(rung.n), config, rung, test::fold);
    };
    const auto order = [](const Config& config, DampingScheme) { return config.law == Law::elastica ? 1 : 2; };
    std::vector<Config> tops = one_at_a_time(choices);
    std::erase_if(tops,
                  [](const Config& config) { return config.law == Law::linear; }); // the default: no force, no law
    return {
        {"free_rod", choices, ladder(20, 4), free_rod, kept, one_at_a_time(choices), order, 4, false},
        {"butterfly", choices, ladder(10, 4), butterfly, kept, one_at_a_time(choices), order, 4, false},
        {"top", choices, ladder(2, 6), top, top_exact, tops, order,
         3}, // the half drifts at both ends make no whole one
    };
}

} // namespace skein::bench
