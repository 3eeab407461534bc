#include "replay.hpp"

#include "scene.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace skein::replay {

namespace {

/// Tolerances of the table of cases, for files without `roundoff_sensitivity`.
double tabulated_tolerance(const std::string& name, const std::string& field) {
    const std::string number = name.substr(0, 2);
    if (number == "02" && field == "omega") return 1e-8;
    if (number == "12" && field == "omega") return 1e-6;
    for (const char* coarse : {"03", "06", "08", "10", "12", "13", "14", "15"})
        if (number == coarse) return 1e-9;
    return 1e-10;
}

/// max(1e-10, 100 x what an initial perturbation of 1e-15 of the length does to the field).
double tolerance_of(const Entry& file, long step, const std::string& field) {
    if (file.has("roundoff_sensitivity"))
        for (const Entry& e : file["roundoff_sensitivity"].list())
            if (e["step"].integer() == step && e.has(field)) return std::max(1e-10, 100 * e[field].number());
    return tabulated_tolerance(file.has("case") ? file["case"].text() : "", field);
}

double largest(const std::vector<double>& values) {
    double most = 0;
    for (const double v : values) most = std::max(most, std::abs(v));
    return most;
}

Integrator integrator_of(const Entry& stepper) {
    if (stepper.text() == "PositionVerlet") return Integrator::verlet;
    if (stepper.text() == "PEFRL") return Integrator::pefrl;
    throw NotBuilt("stepper '" + stepper.text() + "' (" + stepper.path() + ")");
}

/// What a field's deviation is relative to. State: the file's `scale`. Strains are differences of the state over a
/// length: what the scale of the state makes of them, over the shortest rest length; loads that answer internal ones:
/// the stiffness times that, where it is more than the largest value of the file. The rest: that value.
double scale_of(const std::string& field, const Entry& file, const Scene& scene, double largest_value) {
    if (of_state(field)) return file["scale"][field].number();
    const double position = file["scale"]["position"].number(), inv_length = scene.largest_inv_length();
    if (field == "sigma" || field == "dilatation") return position * inv_length;
    if (field == "kappa") return file["scale"]["directors"].number() * inv_length;
    if (field == "external_forces_mid")
        return std::max(largest_value, scene.answering_stiffness() * position * inv_length);
    if (field == "external_torques_mid") return std::max(largest_value, scene.answering_stiffness() * position);
    return largest_value;
}

/// A recorded step, computed and as the file has it, system by system; planes have no fields.
struct Recorded {
    long step;
    std::vector<Fields> computed, reference;
};

/// The steps of a batch with their times summed as published, half step by half step, so that switches fall on the same
/// step. `time` goes from the beginning of the batch to its end.
std::vector<Step> timed(std::span<const Step> batch, const Scheme& scheme, double& time) {
    std::vector<Step> steps(batch.begin(), batch.end());
    for (std::size_t i = 0; i < steps.size(); ++i) {
        const std::size_t stage = i % scheme.stages.size();
        time += (scheme.stages[stage].drift - (stage == 0 ? scheme.lag : 0.0)) * steps[i].dt;
        steps[i].time = time;
        if (steps[i].completes) time += scheme.lag * steps[i].dt;
    }
    return steps;
}

std::vector<Recorded> run(const Entry& file, Scene& scene, const Stepping& stepping, Integrator integrator) {
    std::vector<Recorded> recorded;
    Clock clock(stepping.dt, 0, integrator);
    double time = file.has("start_time") ? file["start_time"].number() : 0.0;
    for (const Entry& output : file["outputs"].list()) {
        const long step = output["step"].integer();
        if (step <= clock.done()) output["step"].fail("does not follow the step before");
        while (clock.done() < step) {
            const auto batch = clock.next(step);
            clock.advance(batch);
            scene.run(timed(batch, stepping.scheme, time));
        }
        Recorded& r = recorded.emplace_back(Recorded{step, scene.fields(clock.lag(), time), {}});
        const auto references = output["systems"].list();
        if (references.size() != r.computed.size()) output["systems"].fail("does not match the systems of the start");
        for (std::size_t i = 0; i < references.size(); ++i)
            r.reference.push_back(r.computed[i].empty() ? Fields{} : reference_fields(references[i], r.computed[i]));
    }
    if (recorded.empty()) file["outputs"].fail("is empty");
    return recorded;
}

/// Largest |difference| of a field over all systems of a step; infinite where a number is not.
double largest_difference(const Recorded& r, const std::string& field) {
    double worst = 0;
    for (std::size_t i = 0; i < r.reference.size(); ++i) {
        const auto reference = r.reference[i].find(field);
        if (reference == r.reference[i].end()) continue;
        const auto& computed = r.computed[i].at(field);
        for (std::size_t j = 0; j < computed.size(); ++j) {
            const double d = std::abs(computed[j] - reference->second[j]);
            if (!(d <= worst)) worst = std::isnan(d) ? INFINITY : d;
        }
    }
    return worst;
}

} // namespace

std::vector<Deviation> replay_systems(const Entry& file) {
    const Integrator integrator = integrator_of(file["stepper"]);
    const Stepping stepping{scheme_of(integrator), file["dt"].positive()};
    Scene scene(file, stepping);
    const auto recorded = run(file, scene, stepping, integrator);

    std::map<std::string, double> largest_value;
    for (const Recorded& r : recorded)
        for (const Fields& system : r.reference)
            for (const auto& [field, values] : system)
                largest_value[field] = std::max(largest_value[field], largest(values));
    std::vector<Deviation> deviations;
    for (const Recorded& r : recorded) {
        double loosest = 0; // tolerance of what follows from the state
        for (const char* field : state_fields) loosest = std::max(loosest, tolerance_of(file, r.step, field));
        for (const auto& [field, most] : largest_value) {
            const double scale = scale_of(field, file, scene, most);
            deviations.push_back({r.step, field, largest_difference(r, field) / (scale > 0 ? scale : 1.0),
                                  of_state(field) ? tolerance_of(file, r.step, field) : loosest});
        }
    }
    return deviations;
}

} // namespace skein::replay
