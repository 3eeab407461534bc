// Eight driven damped cilia in a row, bond 1, over the second half of the field's first turn: their tips at eight
// instants against each law's own finest runs, n = 32, 64 and 128 at a quarter of the automatic step, extrapolated
// twice.
#include "loads/magnetic_field.hpp"
#include "scenes/work_precision/cases.hpp"

namespace skein::bench {

namespace {

Outcome cilium(const Config& config, const Rung& rung) {
    constexpr double begin = 36, interval = 4.5;
    SceneSpec scene = test::cilia_scene(8, rung.n);
    scene.rods[0].magnetisation.strength = 5781.25;
    scene.loads[0].load.as<MagneticField>().ramp = {9};
    scene.time = {.duration = begin + 8 * interval};
    configure(scene, config, rung, interval);
    test::Stage stage(scene, 8);
    Outcome outcome;
    for (int instant = 1; instant <= 8; ++instant) {
        test::advance(stage, std::llround((begin + instant * interval) / stage.plan.dt), outcome.cost);
        for (std::size_t i = 0; i < 8; ++i)
            outcome.value.push_back((1 / scene.rods[0].shape.length) * lane(stage.state(i).back().position, 0));
    }
    return finished(stage, std::move(outcome));
}

std::vector<Vec3d> reference(Law law) {
    const Config fine{.law = law, .step = 0.25};
    const int order = law == Law::elastica ? 1 : 2; // its damping comes after the kick
    const auto coarse = cilium(fine, {32}).value, middle = cilium(fine, {64}).value, finest = cilium(fine, {128}).value;
    return richardson(richardson(coarse, middle, order), richardson(middle, finest, order), 2 * order);
}

} // namespace

std::vector<Case> driven_cases() {
    return {over_elements("cilium", {.clamp = true, .damping = true, .integrator = true, .step = true}, {4, 8, 16, 32},
                          cilium, reference)};
}

} // namespace skein::bench
