// Rods that come to rest: the answer knows neither step nor integrator, and the error is that of the elements and the
// clamp.
#include "scenes/work_precision/cases.hpp"

#include "loads/magnetic_field.hpp"
#include "support/axial_stretching.hpp"
#include "support/catenary.hpp"
#include "support/euler_buckling.hpp"
#include "support/helical_buckling.hpp"
#include "support/large_rotation.hpp"
#include "support/magnetised_elastica.hpp"
#include "support/timoshenko_cantilever.hpp"

namespace skein::bench {

namespace {

using test::Stage;

/// At the end of the scene; `look` makes values of the stage.
template <class Look> auto relaxed(const std::function<SceneSpec(long)>& scene_of, Look look) {
    return [=](const Config& config, const Rung& rung) {
        SceneSpec scene = scene_of(rung.n);
        configure(scene, config, rung, scene.time.duration);
        Stage stage(scene, 1);
        Outcome outcome;
        test::advance(stage, stage.plan.steps, outcome.cost);
        outcome.value = look(stage, config.law);
        return finished(stage, std::move(outcome));
    };
}

std::vector<Vec3d> tip(const Stage& stage, Law) { return {lane(stage.state(0).back().position, 0)}; }

std::vector<Vec3d> thick_tip(const Stage& stage, Law) { return {{relative_deflection(stage), 0, 0}}; }

Vec3d magnetised_tip(Law law) {
    const auto tip = test::magnetised_tip(1, law == Law::incompressible ? test::magnetised_slenderness : 0);
    return {tip.x, 0, tip.z};
}
double magnetised_deflection(Law law) { return norm(magnetised_tip(law) - Vec3d{0, 0, 1}); }

SceneSpec magnetised_scene(long n) {
    const RodSpec rod = test::magnetised_rod(1, n);
    const double omega = test::cantilever_frequency(rod);
    return test::coming_to_rest(rod, omega,
                                {{.load = MagneticField{.constant = test::magnetising_field, .ramp = {1 / omega}}}});
}

double stretched(Law law) { return test::axial_stretching::place(law, 1) - 1; }

constexpr long catenary_parts = 10; ///< looked at where they meet

std::vector<Vec3d> catenary_line(const Stage& stage, Law) {
    const auto state = stage.state(0);
    std::vector<Vec3d> line;
    for (std::size_t k = 0; k < state.size(); k += (state.size() - 1) / catenary_parts)
        line.push_back(lane(state[k].position, 0));
    return line;
}
std::vector<Vec3d> catenary_exact(Law law) {
    std::vector<Vec3d> line;
    for (const auto [x, z] : test::catenary::line(law, test::catenary::horizontal_tension(law), catenary_parts))
        line.push_back({x, 0, z});
    return line;
}

Outcome euler_load(const Config& config, const Rung& rung) {
    const double exact = test::euler_buckling::critical_load(config.law);
    Outcome outcome;
    const double load = test::euler_buckling::measured_load(
        rung.n, exact, outcome.cost,
        [&](SceneSpec scene) {
            configure(scene, config, rung, scene.time.duration);
            return Stage(std::move(scene), 1);
        },
        [&](const Stage& stage, double, double, double) { outcome = finished(stage, std::move(outcome)); });
    outcome.value = {{load / exact, 0, 0}};
    return outcome;
}

constexpr int stations = 20; ///< of the helix, at nodes of all its rungs

Outcome helix(const Config& config, const Rung& rung) {
    SceneSpec scene = test::helical_buckling::scene(config.law, rung.n, 24);
    configure(scene, config, rung, scene.time.duration);
    Stage stage(scene, 1);
    Outcome outcome;
    test::helical_buckling::buckle(stage, outcome.cost);
    const auto state = stage.state(0);
    for (std::size_t i = 1; i < stations; ++i) {
        const std::size_t k = i * static_cast<std::size_t>(rung.n) / stations;
        const double cosine = 0.5 * (frame(state[k - 1]).d3.z + frame(state[k]).d3.z);
        outcome.value.push_back({cosine / test::helical_buckling::localised().depth, 0, 0});
    }
    return finished(stage, std::move(outcome));
}
std::vector<Vec3d> helix_exact(Law) {
    const auto exact = test::helical_buckling::localised();
    std::vector<Vec3d> line;
    for (int i = 1; i < stations; ++i)
        line.push_back({exact.cosine(test::helical_buckling::length * i / stations) / exact.depth, 0, 0});
    return line;
}

} // namespace

double relative_deflection(const Stage& stage) {
    using namespace test::timoshenko_cantilever;
    return lane(stage.state(0).back().position, 0).x / beam.deflection(force, beam.length);
}

std::vector<Case> cases_at_rest() {
    constexpr Choices clamped{.clamp = true, .damping = true}, free{.damping = true};
    const std::vector<long> five{5, 10, 20, 40, 80};
    const auto one = [](Law) { return std::vector<Vec3d>{{1, 0, 0}}; };
    const auto scaled_by = [](auto scale) {
        return [=](const Stage& stage, Law law) { return std::vector<Vec3d>{(1 / scale(law)) * tip(stage, law)[0]}; };
    };
    const auto large_rotation = [&](const std::string& name, const test::large_rotation::TipLoad& load) {
        return over_elements(name, clamped, five,
                             relaxed([load](long n) { return test::large_rotation::scene(load, n); }, tip),
                             [load](Law law) { return std::vector<Vec3d>{test::large_rotation::tip(law, load)}; });
    };
    std::vector<Case> cases{
        over_elements("timoshenko", clamped, five, relaxed(test::timoshenko_cantilever::scene, thick_tip), one),
        over_elements(
            "magnetised", clamped, {5, 10, 20, 40}, relaxed(magnetised_scene, scaled_by(magnetised_deflection)),
            [](Law law) { return std::vector<Vec3d>{(1 / magnetised_deflection(law)) * magnetised_tip(law)}; }),
        large_rotation("large_rotation", test::large_rotation::straight),
        large_rotation("bend", test::large_rotation::bend),
        over_elements("axial_stretching", free, five, relaxed(test::axial_stretching::scene, scaled_by(stretched)),
                      [](Law law) {
                          return std::vector<Vec3d>{{0, 0, test::axial_stretching::place(law, 1) / stretched(law)}};
                      }),
        over_elements("catenary", free, {10, 20, 40, 80}, relaxed(test::catenary::scene, catenary_line),
                      catenary_exact),
        over_elements("euler_buckling", clamped, five, euler_load, one),
        over_elements("helical_buckling", clamped, {100, 200}, helix, helix_exact),
    };
    for (Case& c : cases)
        if (c.name == "bend") c.next_order = 3; // the wall's moment is resolved in the frame of the half cell's middle
    return cases;
}

} // namespace skein::bench
