#include "fields.hpp"

#include "core/rotation.hpp"

#include <algorithm>

namespace skein::replay {

namespace {

void append(std::vector<double>& list, const Vec3d& a) { list.insert(list.end(), {a.x, a.y, a.z}); }

/// All numbers of nested lists.
void flatten(const Entry& e, std::vector<double>& list) {
    if (!e.json().is_array()) return list.push_back(e.number());
    for (const Entry& item : e.list()) flatten(item, list);
}

} // namespace

bool of_state(const std::string& field) {
    return std::find(std::begin(state_fields), std::end(state_fields), field) != std::end(state_fields);
}

Fields fields_of(const Rod& rod, const std::vector<Slot<1>>& state) {
    const RodGroup& g = rod.group;
    const std::size_t n = rod.elements();
    Fields f;
    double translational = 0, rotational = 0, bending = 0, shear = 0;
    for (std::size_t i = 0; i < rod.nodes(); ++i) {
        const Vec3d v = lane(state[i].velocity, 0);
        append(f["position"], lane(state[i].position, 0));
        append(f["velocity"], v);
        append(f["external_forces_mid"], lane(rod.external[i].force, 0));
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
        append(f["external_torques_mid"], lane(rod.external[k].couple, 0));
        f["dilatation"].push_back(e);
        rotational += 0.5 * dot(w, scale(c.inertia, w)) / e;
        shear += 0.5 * c.rest_length * dot(strain, scale(c.stiffness, strain));
    }
    for (std::size_t k = 0; k < g.voronoi.size(); ++k) {
        const VoronoiConstants& c = g.voronoi[k];
        const Vec3d kappa = c.inv_length * lane(relative_rotation(state[(k + 1) % n].director, state[k].director), 0),
                    bend = kappa - c.rest_curvature;
        append(f["kappa"], kappa);
        bending += 0.5 / c.inv_length * dot(bend, scale(c.stiffness, bend));
    }
    f["energy"] = {translational, rotational, bending, shear};
    return f;
}

Fields fields_of(const RigidBody& body, const Slot<1>& state) {
    Fields f;
    append(f["position"], lane(state.position, 0));
    append(f["velocity"], lane(state.velocity, 0));
    const Mat3d q = frame(state);
    for (const Vec3d& row : {q.d1, q.d2, q.d3}) append(f["directors"], row);
    append(f["omega"], lane(state.spin, 0));
    append(f["external_forces_mid"], body.force);
    append(f["external_torques_mid"], body.couple);
    return f;
}

Fields reference_fields(const Entry& e, const Fields& computed) {
    Fields f;
    for (const auto& [name, values] : computed) {
        if (!of_state(name) && !e.has(name)) continue;
        const Entry field = e[name];
        if (name == "energy")
            f[name] = {field["translational"].number(), field["rotational"].number(), field["bending"].number(),
                       field["shear"].number()};
        else flatten(field, f[name]);
        if (f[name].size() != values.size())
            field.fail("has " + std::to_string(f[name].size()) + " numbers, not " + std::to_string(values.size()));
    }
    return f;
}

} // namespace skein::replay
