#include "rigid_body.hpp"

#include "drift.hpp"

#include "skein/loads/ramp.hpp"

#include <cmath>

namespace skein::replay {

namespace {

void drift_body(Slot<1>& s, double length) {
    const Pack<1> h(length);
    s.position = fma(h, s.velocity, s.position);
    PublishedTop::turn(ElementConstants{}, s.director, s.spin, h);
}

/// The published uniform damper; the others divide by the masses of a rod's nodes.
double kept_by(const Entry& damper) {
    if (damper["kind"].text() != "analytical_linear" || !damper.has("uniform_damping_constant"))
        throw NotBuilt("damper '" + damper["kind"].text() + "' on a body, unless uniform (" + damper.path() + ")");
    return std::exp(-damper["uniform_damping_constant"].number() * damper["time_step"].positive());
}

} // namespace

RigidBody read_body(const Entry& e) {
    const bool sphere = e["kind"].text() == "sphere";
    const double radius = e["radius"].positive_scalar();
    const Entry diagonal = e["mass_second_moment_of_inertia"];
    const Vec3d inertia = diagonal.json().size() == 1 ? diagonal.vectors(1)[0] : diagonal.vector();
    if (!(inertia.x > 0 && inertia.y > 0 && inertia.z > 0)) diagonal.fail("is not positive");
    const Quaterniond director = quaternion(e["directors"].matrices(1)[0]);
    return {.shape = sphere ? RigidBody::Shape::sphere : RigidBody::Shape::cylinder,
            .radius = radius,
            .length = sphere ? 2 * radius : e["length"].positive_scalar(),
            .mass = e["mass"].positive_scalar(),
            .inertia = inertia,
            .slot = {broadcast<1>(e["position"].vectors(1)[0]), broadcast<1>(e["velocity"].vectors(1)[0]),
                     broadcast<1>(director), broadcast<1>(e["omega"].vectors(1)[0])}};
}

BodyProgram::BodyProgram(RigidBody& body, const Stepping& stepping, const std::vector<Entry>& constraints,
                         const std::vector<Entry>& dampers)
    : body_(body), stages_(stepping.scheme.stages.size()) {
    for (const Entry& e : constraints) constraints_.push_back(make_constraint(e, {&body.slot, 1}, 1, 1));
    for (const Entry& e : dampers) kept_ *= kept_by(e);
}

void BodyProgram::move(const Step& step) const {
    const auto [count, length] = drifts_of(step, stages_);
    for (int i = 0; i < count; ++i) drift_body(body_.slot, length);
    for (const auto& constraint : constraints_) constraint->values(&body_.slot, step.time);
}

void BodyProgram::kick(const Step& step) const {
    const Vec3d w = lane(body_.slot.spin, 0), &j = body_.inertia;
    const Vec3d couple = cross(scale(j, w), w) + body_.couple;
    body_.slot.velocity = broadcast<1>(fma(step.kick / body_.mass, body_.force, body_.velocity()));
    body_.slot.spin = broadcast<1>(fma(step.kick, Vec3d{couple.x / j.x, couple.y / j.y, couple.z / j.z}, w));
    for (const auto& constraint : constraints_) constraint->rates(&body_.slot, step.time);
    body_.slot.velocity = Pack<1>(kept_) * body_.slot.velocity;
    body_.slot.spin = Pack<1>(kept_) * body_.slot.spin;
}

Slot<1> BodyProgram::closed_state(double lag, double time) const {
    Slot<1> state = body_.slot;
    drift_body(state, lag);
    for (const auto& constraint : constraints_) constraint->values(&state, time);
    return state;
}

std::function<void(const Step&)> make_body_load(const Entry& e, RigidBody& body) {
    const std::string kind = e["kind"].text();
    if (kind == "gravity")
        return [&body, weight = body.mass * e["acc"].vector()](const Step&) { body.force += weight; };
    if (kind == "uniform_torques")
        return [&body, torque = e["torque"].vector()](const Step&) { body.couple += frame(body.slot) * torque; };
    if (kind == "endpoint_forces") // its first node is its last
        return [&body, sum = e["start_force"].vector() + e["end_force"].vector(),
                ramp = e["ramp_up_time"].number()](const Step& step) { body.force += ramp_at(step.time, ramp) * sum; };
    throw NotBuilt("load '" + kind + "' on a body (" + e.path() + ")");
}

} // namespace skein::replay
