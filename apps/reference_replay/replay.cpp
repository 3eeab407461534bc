#include "replay.hpp"

#include "drift.hpp"
#include "system.hpp"

#include "core/rotation.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace skein::replay {

namespace {

using Fields = std::map<std::string, std::vector<double>>; ///< of one rod at one step, flat, in the order of the file
constexpr const char* state_fields[] = {"position", "velocity", "directors", "omega"};
bool of_state(const std::string& field) { return std::find(std::begin(state_fields), std::end(state_fields), field) != std::end(state_fields); }

void append(std::vector<double>& list, const Vec3d& a) { list.insert(list.end(), {a.x, a.y, a.z}); }

/// All numbers of nested lists.
void flatten(const Entry& e, std::vector<double>& list) {
    if (!e.json().is_array()) return list.push_back(e.number());
    for (const Entry& item : e.list()) flatten(item, list);
}

/// State and what follows from it, with the published definitions.
Fields fields_of(const System& system, const std::vector<Slot<1>>& state, const External& loads) {
    const RodGroup& g = system.group;
    const auto n = static_cast<std::size_t>(g.elements());
    const std::size_t nodes = g.closed() ? n : n + 1;
    Fields f;
    double translational = 0, rotational = 0, bending = 0, shear = 0;
    for (std::size_t i = 0; i < nodes; ++i) {
        const Vec3d v = lane(state[i].velocity, 0);
        append(f["position"], lane(state[i].position, 0));
        append(f["velocity"], v);
        append(f["external_forces_mid"], lane(loads.sum()[i].force, 0));
        translational += 0.5 * g.node_mass[i] * dot(v, v);
    }
    for (std::size_t k = 0; k < n; ++k) {
        const ElementConstants& c = g.element[k];
        const Mat3d q = frame(state[k]);
        const Vec3d dx = lane(state[k + 1].position, 0) - lane(state[k].position, 0), w = lane(state[k].spin, 0);
        const Vec3d sigma = c.inv_rest_length * (q * dx) - Vec3d{0, 0, 1}, strain = sigma - c.rest_strain;
        const double e = c.inv_rest_length * norm(dx);
        for (const Vec3d& row : {q.d1, q.d2, q.d3}) append(f["directors"], row);
        append(f["omega"], w);
        append(f["sigma"], sigma);
        append(f["external_torques_mid"], lane(loads.sum()[k].couple, 0));
        f["dilatation"].push_back(e);
        rotational += 0.5 * dot(w, scale(c.inertia, w)) / e;
        shear += 0.5 * c.rest_length * dot(strain, scale(c.stiffness, strain));
    }
    for (std::size_t k = 0; k < g.voronoi.size(); ++k) {
        const VoronoiConstants& c = g.voronoi[k];
        const Vec3d kappa = c.inv_length * lane(relative_rotation(state[(k + 1) % n].director, state[k].director), 0), bend = kappa - c.rest_curvature;
        append(f["kappa"], kappa);
        bending += 0.5 / c.inv_length * dot(bend, scale(c.stiffness, bend));
    }
    f["energy"] = {translational, rotational, bending, shear};
    return f;
}

Fields reference_fields(const Entry& e, const Fields& computed) {
    Fields f;
    for (const auto& [name, values] : computed) {
        if (!of_state(name) && !e.has(name)) continue;
        const Entry field = e[name];
        if (name == "energy")
            f[name] = {field["translational"].number(), field["rotational"].number(), field["bending"].number(), field["shear"].number()};
        else flatten(field, f[name]);
        if (f[name].size() != values.size()) field.fail("has " + std::to_string(f[name].size()) + " numbers, not " + std::to_string(values.size()));
    }
    return f;
}

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

/// What a field's deviation is relative to. State: the file's `scale`. Strains are differences of the state over a length: what the
/// scale of the state makes of them. The rest: the largest value of the file.
double scale_of(const std::string& field, const Entry& file, const std::vector<System>& systems, double largest_value) {
    if (of_state(field)) return file["scale"][field].number();
    double inv_length = 0;
    for (const System& s : systems)
        for (const ElementConstants& c : s.group.element) inv_length = std::max(inv_length, c.inv_rest_length);
    if (field == "sigma" || field == "dilatation") return file["scale"]["position"].number() * inv_length;
    if (field == "kappa") return file["scale"]["directors"].number() * inv_length;
    return largest_value;
}

/// A recorded step, computed and as the file has it, rod by rod.
struct Recorded {
    long step;
    std::vector<Fields> computed, reference;
};

/// The steps of a batch with their times summed as published, half step by half step, so that switches fall on the same step.
/// `time` goes from the beginning of the batch to its end.
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

std::vector<Recorded> run(const Entry& file, const std::vector<System>& systems) {
    const Integrator integrator = integrator_of(file["stepper"]);
    const Stepping stepping{scheme_of(integrator), file["dt"].positive()};
    std::vector<RodGroup> groups;
    std::vector<LocalRod> owned;
    std::vector<TileProgram<1>> passes;
    std::vector<Program> programs; // what is left of them: constraints, loads
    for (const System& system : systems) {
        const int number = static_cast<int>(groups.size());
        programs.push_back(make_program(file, system, number, stepping));
        passes.push_back(std::move(programs.back().passes));
        groups.push_back(system.group);
        owned.push_back({number, number, 0});
    }
    const Threads one(1);
    const Tiling each_alone{std::vector<std::int64_t>(systems.size(), 1), {}};
    RodTiles<1> rods(groups, std::move(owned), each_alone, std::move(passes), one);
    for (std::size_t i = 0; i < systems.size(); ++i) rods.import_rod(i, systems[i].start);

    std::vector<Recorded> recorded;
    Clock clock(stepping.dt, 0, integrator);
    double time = file.has("start_time") ? file["start_time"].number() : 0.0;
    for (const Entry& output : file["outputs"].list()) {
        const long step = output["step"].integer();
        if (step <= clock.done()) output["step"].fail("does not follow the step before");
        while (clock.done() < step) {
            const auto batch = clock.next(step);
            clock.advance(batch);
            const auto steps = timed(batch, stepping.scheme, time);
            rods.visit(steps, false);
        }
        const auto references = output["systems"].list();
        if (references.size() != systems.size()) output["systems"].fail("does not match the systems of the start");
        Recorded& r = recorded.emplace_back(Recorded{step, {}, {}});
        for (std::size_t i = 0; i < systems.size(); ++i) {
            std::vector<Slot<1>> state(systems[i].start.size());
            rods.export_rod(i, state);
            close_step(systems[i].group, state, clock.lag());
            for (const auto& constraint : programs[i].constraints) constraint->values(state.data(), time);
            if (systems[i].group.closed()) state.back().position = state.front().position;
            r.computed.push_back(fields_of(systems[i], state, *programs[i].loads));
            r.reference.push_back(reference_fields(references[i], r.computed.back()));
        }
    }
    if (recorded.empty()) file["outputs"].fail("is empty");
    return recorded;
}

/// Largest |difference| of a field over all rods of a step; infinite where a number is not.
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

std::vector<Deviation> replay_rods(const Entry& file) {
    std::vector<System> systems;
    for (const Entry& e : file["systems"].list()) systems.push_back(read_system(e, static_cast<int>(systems.size())));
    const auto recorded = run(file, systems);

    std::map<std::string, double> largest_value;
    for (const Recorded& r : recorded)
        for (const Fields& rod : r.reference)
            for (const auto& [field, values] : rod) largest_value[field] = std::max(largest_value[field], largest(values));
    std::vector<Deviation> deviations;
    for (const Recorded& r : recorded) {
        double loosest = 0; // tolerance of what follows from the state
        for (const char* field : state_fields) loosest = std::max(loosest, tolerance_of(file, r.step, field));
        for (const auto& [field, most] : largest_value) {
            const double scale = scale_of(field, file, systems, most);
            deviations.push_back({r.step, field, largest_difference(r, field) / (scale > 0 ? scale : 1.0),
                                  of_state(field) ? tolerance_of(file, r.step, field) : loosest});
        }
    }
    return deviations;
}

} // namespace skein::replay
