// Undamped rods of small motion let go in one mode. The projection on the mode is cos(W t); after a quarter period, or
// two and a quarter, that is zero and its error is the phase's, rad.
#include "scenes/work_precision/cases.hpp"

#include "support/cantilever_modes.hpp"
#include "support/standing_wave.hpp"

namespace skein::bench {

namespace {

using test::Stage;

/// The share of the start's projection left at the end of the scene.
template <class Projection> Outcome let_go(Stage& stage, Projection&& projection) {
    const double start = projection();
    Outcome outcome;
    test::advance(stage, stage.plan.steps, outcome.cost);
    outcome.value = {{projection() / start, 0, 0}};
    return finished(stage, std::move(outcome));
}

constexpr test::TimoshenkoBeam slender{1, 0.02, 1, 1, 1.0 / 3};

template <std::size_t mode> Outcome bending_mode(const Config& config, const Rung& rung) {
    static const double frequency = slender.frequencies<mode + 1>()[mode];
    SceneSpec scene = test::clamped_beam(slender, rung.n, 0.5 * std::numbers::pi / frequency);
    configure(scene, config, rung, scene.time.duration);
    Stage stage(scene, 1);
    test::ModeShape shape(slender, frequency, rung.n);
    if (config.clamp == EndKind::clamped_frozen) shape.theta[0] = 0; // frozen means upright
    shape.displace(stage, 0, 1e-4);
    return let_go(stage, [&] { return shape.projection(stage, 0); });
}

template <test::Wave kind> Outcome standing_wave(const Config& config, const Rung& rung) {
    const test::StandingWave wave{kind, rung.n};
    SceneSpec scene = wave.scene(4.5 * std::numbers::pi / wave.frequency());
    configure(scene, config, rung, scene.time.duration);
    Stage stage(scene, 1);
    wave.displace(stage);
    if (kind == test::Wave::torsional && config.clamp == EndKind::clamped_frozen) {
        auto state = stage.state(0);
        set_lane(state[0].director, 0, no_turn);
        stage.rods->import_rod(0, state);
    }
    return let_go(stage, [&] {
        const auto state = stage.state(0);
        double sum = 0;
        for (std::size_t i = 0; i < wave.count(); ++i) {
            const double weight =
                kind == test::Wave::axial ? stage.groups[0].node_mass[i] : 1; // inertia: the same in all elements
            sum += weight * wave.shape(i) * wave.displacement(state, i);
        }
        return sum;
    });
}

} // namespace

std::vector<Case> cases_of_waves() {
    constexpr Choices clamped{.clamp = true, .integrator = true, .step = true}, axial{.integrator = true, .step = true};
    const std::vector<long> five{5, 10, 20, 40, 80};
    const auto none = [](Law) { return std::vector<Vec3d>{{0, 0, 0}}; };
    return {
        over_elements("bending_mode_0", clamped, five, bending_mode<0>, none),
        over_elements("bending_mode_1", clamped, five, bending_mode<1>, none),
        over_elements("axial_wave", axial, five, standing_wave<test::Wave::axial>, none),
        over_elements("torsional_wave", clamped, five, standing_wave<test::Wave::torsional>, none),
    };
}

} // namespace skein::bench
