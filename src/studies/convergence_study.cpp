#include "studies/convergence_study.hpp"

#include "partition/partition.hpp"
#include "physics/contact/contact_plan.hpp"
#include "physics/loads/load_plan.hpp"
#include "scene/make_groups.hpp"
#include "scene/make_plan.hpp"
#include "scene/scene_refine.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"
#include "studies/scene_family.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace skein {

namespace {

constexpr std::int64_t samples_wanted = 32;  ///< where the scene asks for no time series
constexpr std::int64_t steps_to_settle = 64; ///< between two looks whether rods that relax have settled

/// The scene with no other outputs than those that runs are compared by.
SceneSpec with_samples_alone(SceneSpec scene, double interval) {
    const OutputSpec was = scene.output;
    scene.output = {};
    scene.fluid_outputs.clear();
    scene.output.series = scene.output.tips = interval;
    scene.output.precision = Precision::double_;
    scene.output.observables = was.observables;
    scene.output.audit = was.audit;
    scene.output.checkpoint_wall = was.checkpoint_wall;
    return scene;
}

/// Whole steps between samples: those of the scene's series, or else about a 32nd of the run.
std::int64_t steps_between(const Plan& plan) {
    if (plan.pseudo_time) return std::min(steps_to_settle, plan.steps);
    if (plan.cadence.of("series") > 0) return plan.cadence.of("series");
    std::int64_t count = std::min(samples_wanted, plan.steps);
    while (plan.steps % count != 0) --count;
    return plan.steps / count;
}

Plan plan_with(const Communicator& comm, const Machine& machine, const SceneSpec& scene) {
    return make_plan(scene, groups_for_all(comm, scene), machine);
}

long most_elements(const SceneSpec& scene) {
    long most = 0;
    for (const RodSpec& rods : scene.rods)
        if (!rods.body) most = std::max(most, rods.shape.elements);
    return most;
}

void refuse_fixed_elements(const SceneSpec& scene) {
    if (most_elements(scene) == 0)
        throw InputError(scene.file + ": there are none but rigid bodies, which have no elements to refine");
}

/// Refinement of the run with this number among those of other elements.
Refinement refinement(std::size_t number, bool coarser) { return {1L << number, coarser ? 2 : 1}; }

/// Orders of the error of a step: forces that read velocities before the kick are of first order.
int time_order_of(const Plan& plan, std::span<const RodGroup> groups) {
    if (plan.has<TouchPlan>()) return 1;
    const auto* loads = plan.find<LoadPlan>();
    for (std::size_t g = 0; g < plan.groups.size(); ++g) {
        const GroupPlan& p = plan.groups[g];
        if (groups[g].law() == Law::elastica || (!p.undamped && p.damping_scheme == DampingScheme::after)) return 1;
        for (const std::size_t i : loads->of_group[g])
            if (const Load& load = loads->loads[i]; load.acts_last() || load.largest_rate(groups[g]).value > 0)
                return 1;
    }
    return plan.integrator == Integrator::pefrl ? 4 : 2;
}

/// The run of a scene whose step is a share of the given one.
StudyRun run_of(const Communicator& comm, const Machine& machine, SceneSpec scene, const Plan& given,
                std::int64_t every, std::int64_t share) {
    StudyRun run;
    run.dt = given.dt / static_cast<double>(share);
    if (!given.pseudo_time) scene.time.dt = run.dt;
    const Plan plan = plan_with(comm, machine, scene);
    if (plan.steps != given.steps * share || plan.cadence.of("series") != every * share)
        throw std::logic_error(
            fmt::format("samples of {} steps of {:g} s are not those of {} steps", plan.steps, plan.dt, given.steps));
    run.elements = most_elements(scene);
    run.name = fmt::format("{}_{:.6g}", run.elements, run.dt);
    run.steps = plan.steps;
    run.predicted = plan.predicted_s * machine.ranks * std::min(machine.threads, machine.cores);
    run.scene = std::move(scene);
    return run;
}

} // namespace

std::vector<RodGroup> groups_for_all(const Communicator& comm, const SceneSpec& scene) {
    std::vector<RodGroup> groups = make_groups(scene);
    read_rods(comm, groups);
    return groups;
}

Study make_study(const Communicator& comm, const Machine& machine, const SceneSpec& scene, bool coarser) {
    refuse_fixed_elements(scene);
    Study study{.given = coarser ? std::size_t{1} : std::size_t{0},
                .at_rest = scene.time.rest_speed > 0 || scene.time.relax,
                .method = scene.time.relax ? StudyMethod::relaxation : StudyMethod::steps,
                .notes = refinement_notes(scene)};

    // An automatic step depends on what it divides, so the scene's own plan decides it; without a series it divides the
    // samples.
    SceneSpec as_given = scene;
    if (scene.output.series == 0 && scene.time.dt == 0 && !scene.time.relax)
        as_given.output.series = scene.time.duration / samples_wanted;
    const std::vector<RodGroup> groups = groups_for_all(comm, as_given);
    const Plan given = make_plan(as_given, groups, machine);
    const std::int64_t every = steps_between(given);
    SceneSpec base = with_samples_alone(scene, static_cast<double>(every) * given.dt);
    base.time.duration = static_cast<double>(given.steps) * given.dt;
    study.time_order = time_order_of(given, groups);
    study.duration = base.time.duration;

    const auto automatic_dt = [&](SceneSpec of) {
        if (of.time.relax) return given.dt;
        of.time.dt = 0;
        of.time.divide = static_cast<double>(every) * given.dt;
        return plan_with(comm, machine, of).dt;
    };
    constexpr double rounding = 1e-6;
    const double own_limit = automatic_dt(base),
                 boldness = std::max(1.0, given.dt / own_limit); // of a step given by hand
    for (std::size_t k = 0; k < 3; ++k) {
        SceneSpec of = k == study.given ? base : refined(base, refinement(k, coarser));
        const double limit = boldness * (k == study.given ? own_limit : automatic_dt(of));
        const auto share = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(given.dt / limit - rounding)));
        study.runs[k] = run_of(comm, machine, std::move(of), given, every, share);
        study.runs[k].dt_limit = limit;
    }
    study.runs[Study::half_step] = study.runs[study.given];
    if (study.halves_step()) study.runs[Study::half_step] = run_of(comm, machine, base, given, every, 2);
    study.runs[Study::half_step].dt_limit = study.runs[study.given].dt_limit;
    return study;
}

Study make_solved_study(const SceneSpec& scene, StudyMethod method, bool coarser) {
    refuse_unsolvable(scene);
    refuse_fixed_elements(scene);
    Study study{.given = coarser ? std::size_t{1} : std::size_t{0},
                .at_rest = true,
                .method = method,
                .duration = scene.time.duration,
                .notes = refinement_notes(scene)};
    SceneSpec base = with_samples_alone(scene, scene.time.duration);
    if (!base.time.relax) base.time.dt = 0; // no step is made
    for (std::size_t k = 0; k < 3; ++k) {
        StudyRun& run = study.runs[k];
        run.scene = k == study.given ? base : refined(base, refinement(k, coarser));
        run.changes = changes_between(base, run.scene);
        run.elements = most_elements(run.scene);
        run.name = fmt::format("{}_{}", run.elements, nth(study_method_names, method));
    }
    study.runs[Study::half_step] = study.runs[study.given];
    return study;
}

} // namespace skein
