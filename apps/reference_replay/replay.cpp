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
        const Mat3d q = lane(state[k].director, 0);
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
        const bool needed = std::find(std::begin(state_fields), std::end(state_fields), name) != std::end(state_fields);
        if (!needed && !e.has(name)) continue;
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
    if (std::find(std::begin(state_fields), std::end(state_fields), field) != std::end(state_fields)) return file["scale"][field].number();
    double inv_length = 0;
    for (const System& s : systems)
        for (const ElementConstants& c : s.group.element) inv_length = std::max(inv_length, c.inv_rest_length);
    if (field == "sigma" || field == "dilatation") return file["scale"]["position"].number() * inv_length;
    if (field == "kappa") return file["scale"]["directors"].number() * inv_length;
    return largest_value;
}

} // namespace

std::vector<Deviation> replay_rods(const Entry& file) {
    const Integrator integrator = integrator_of(file["stepper"]);
    const Stepping stepping{scheme_of(integrator), file["dt"].positive()};
    std::vector<System> systems;
    for (const Entry& e : file["systems"].list()) systems.push_back(read_system(e, static_cast<int>(systems.size())));
    std::vector<RodGroup> groups;
    std::vector<LocalRod> owned;
    std::vector<TileProgram<1>> programs;
    std::vector<std::vector<std::shared_ptr<const Constraint>>> constraints;
    std::vector<const External*> loads;
    for (std::size_t i = 0; i < systems.size(); ++i) {
        Program program = make_program(file, systems[i], static_cast<int>(i), stepping);
        groups.push_back(systems[i].group);
        owned.push_back({static_cast<std::int64_t>(i), static_cast<int>(i), 0});
        programs.push_back(std::move(program.passes));
        constraints.push_back(std::move(program.constraints));
        loads.push_back(program.loads);
    }
    const Threads one(1);
    RodTiles<1> rods(groups, std::move(owned), std::move(programs), one);
    for (std::size_t i = 0; i < systems.size(); ++i) rods.import_rod(i, systems[i].start);

    struct Compared {
        long step;
        std::vector<Fields> computed, reference; ///< one per system
    };
    std::vector<Compared> compared;
    Clock clock(stepping.dt, 0, integrator);
    double time = file.has("start_time") ? file["start_time"].number() : 0.0;
    std::vector<Step> steps;
    const auto outputs = file["outputs"].list();
    if (outputs.empty()) file["outputs"].fail("is empty");
    for (const Entry& output : outputs) {
        const long step = output["step"].integer();
        if (step <= clock.done()) output["step"].fail("does not follow the step before");
        while (clock.done() < step) {
            const auto batch = clock.next(step);
            clock.advance(batch);
            steps.assign(batch.begin(), batch.end());
            for (std::size_t i = 0; i < steps.size(); ++i) { // time is summed as published, so that switches fall on the same step
                const std::size_t stage = i % stepping.scheme.stages.size();
                time += (stepping.scheme.stages[stage].drift - (stage == 0 ? stepping.scheme.lag : 0.0)) * stepping.dt;
                steps[i].time = time;
                if (steps[i].completes) time += stepping.scheme.lag * stepping.dt;
            }
            rods.visit(steps, false);
        }
        const auto references = output["systems"].list();
        if (references.size() != systems.size()) output["systems"].fail("does not match the systems of the start");
        Compared& c = compared.emplace_back(Compared{step, {}, {}});
        for (std::size_t i = 0; i < systems.size(); ++i) {
            std::vector<Slot<1>> state(systems[i].start.size());
            rods.export_rod(i, state);
            close_step(systems[i].group, state, clock.lag());
            for (const auto& constraint : constraints[i]) constraint->values(state.data(), time);
            c.computed.push_back(fields_of(systems[i], state, *loads[i]));
            c.reference.push_back(reference_fields(references[i], c.computed.back()));
        }
    }

    std::map<std::string, double> largest_value;
    for (const Compared& c : compared)
        for (const Fields& rod : c.reference)
            for (const auto& [name, values] : rod) largest_value[name] = std::max(largest_value[name], largest(values));
    std::vector<Deviation> deviations;
    for (const Compared& c : compared) {
        double loosest = 0; // tolerance of what follows from the state
        for (const char* name : state_fields) loosest = std::max(loosest, tolerance_of(file, c.step, name));
        for (const auto& [name, most] : largest_value) {
            const bool state = std::find(std::begin(state_fields), std::end(state_fields), name) != std::end(state_fields);
            const double scale = scale_of(name, file, systems, most);
            double worst = 0;
            for (std::size_t i = 0; i < systems.size(); ++i)
                if (const auto reference = c.reference[i].find(name); reference != c.reference[i].end())
                    for (std::size_t j = 0; j < reference->second.size(); ++j) {
                        const double d = std::abs(c.computed[i].at(name)[j] - reference->second[j]) / (scale > 0 ? scale : 1.0);
                        if (!(d <= worst)) worst = std::isnan(d) ? INFINITY : d;
                    }
            deviations.push_back({c.step, name, worst, state ? tolerance_of(file, c.step, name) : loosest});
        }
    }
    return deviations;
}

} // namespace skein::replay
