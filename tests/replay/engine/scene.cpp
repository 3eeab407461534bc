#include "scene.hpp"

#include "joints.hpp"
#include "loads.hpp"
#include "rod_body_contact.hpp"
#include "rod_rod_contact.hpp"
#include "rod_self_contact.hpp"

#include <algorithm>

namespace skein::replay {

Scene::Scene(const Entry& file, const Stepping& stepping) {
    for (const Entry& e : file["systems"].list()) {
        const std::string kind = e["kind"].text();
        if (kind == "rod") systems_.emplace_back(read_rod(e, static_cast<int>(systems_.size())));
        else if (kind == "cylinder" || kind == "sphere") systems_.emplace_back(read_body(e));
        else if (kind == "plane") systems_.emplace_back(read_plane(e));
        else throw NotBuilt("system '" + kind + "' (" + e.path() + ")");
    }
    const auto entries_of = [&](const char* list, std::size_t number) {
        std::vector<Entry> found;
        for (const Entry& e : file[list].list()) {
            if (e.has("other")) throw NotBuilt("'" + e["kind"].text() + "' between systems (" + e.path() + ")");
            if (place(e["system"]) == number) found.push_back(e);
        }
        return found;
    };
    for (std::size_t i = 0; i < systems_.size(); ++i) {
        const auto constraints = entries_of("constraints_in_order", i), dampers = entries_of("dampers_in_order", i);
        if (Rod* rod = std::get_if<Rod>(&systems_[i])) rods_.emplace_back(*rod, stepping, constraints, dampers);
        else if (RigidBody* body = std::get_if<RigidBody>(&systems_[i]))
            bodies_.emplace_back(*body, stepping, constraints, dampers);
        else if (!constraints.empty()) throw NotBuilt("constraint on a plane (" + constraints[0].path() + ")");
        else if (!dampers.empty()) throw NotBuilt("damper on a plane (" + dampers[0].path() + ")");
    }
    for (const Entry& e : file["forces_in_order"].list()) loads_.push_back(load_of(e));
}

template <class Kind> Kind& Scene::system(const Entry& number, const char* what) {
    Kind* found = std::get_if<Kind>(&systems_[place(number)]);
    if (!found) number.fail(std::string("is not ") + what);
    return *found;
}

Rod& Scene::open_rod(const Entry& number) {
    Rod& rod = system<Rod>(number, "a rod");
    if (rod.group.closed())
        throw NotBuilt("contact or joint of a ring (" + number.path() +
                       ")"); // published codes have no node after the last
    return rod;
}

Scene::Load Scene::load_of(const Entry& e) {
    const std::string kind = e["kind"].text();
    const bool on_plane = kind == "rod_plane" || kind == "rod_plane_anisotropic_friction";
    answers_ = answers_ || on_plane || kind == "rod_rod_contact";
    if (kind == "rod_rod_contact")
        return [&a = open_rod(e["system"]), &b = open_rod(e["other"]), contact = RodRodContact(e)](const Step&) {
            contact.add(a, b);
        };
    if (kind == "rod_self_contact")
        return [&rod = open_rod(e["system"]), contact = RodSelfContact(e)](const Step&) { contact.add(rod); };
    if (kind == "rod_cylinder_contact" || kind == "rod_sphere_contact") {
        RigidBody& body = system<RigidBody>(e["other"], "a body");
        if ((kind == "rod_sphere_contact") != (body.shape == RigidBody::Shape::sphere))
            e["other"].fail("is not the body of a '" + kind + "'");
        return
            [&rod = open_rod(e["system"]), &body, contact = RodBodyContact(e)](const Step&) { contact.add(rod, body); };
    }
    if (on_plane)
        return [&rod = open_rod(e["system"]), &plane = system<Plane>(e["other"], "a plane"),
                friction = PlaneFriction(e)](const Step&) { friction.add(rod, plane); };
    if (kind == "free_joint" || kind == "hinge_joint" || kind == "fixed_joint") {
        Rod &a = open_rod(e["system"]), &b = open_rod(e["other"]);
        return [&a, &b, joint = PointJoint(e, a, b)](const Step&) { joint.add(a, b); };
    }
    if (kind == "surface_joint_side_by_side") {
        Rod &a = open_rod(e["system"]), &b = open_rod(e["other"]);
        return [&a, &b, joint = SideJoint(e, a, b)](const Step&) { joint.add(a, b); };
    }
    if (e.has("other")) throw NotBuilt("'" + kind + "' between systems (" + e.path() + ")");
    System& on = systems_[place(e["system"])];
    if (Rod* rod = std::get_if<Rod>(&on)) return load_on_rod(e, *rod);
    if (RigidBody* body = std::get_if<RigidBody>(&on)) return make_body_load(e, *body);
    throw NotBuilt("load '" + kind + "' on a plane (" + e.path() + ")");
}

Scene::Load Scene::load_on_rod(const Entry& e, Rod& rod) {
    auto& pass = passes_.emplace_back(make_load(e, rod.group));
    pass->bind(rod.tile());
    return [&rod, pass = pass.get()](const Step& step) { pass->run(rod.tile(), rod.external.data(), step); };
}

void Scene::clear_loads() {
    for (System& system : systems_) {
        if (Rod* rod = std::get_if<Rod>(&system)) std::fill(rod->external.begin(), rod->external.end(), SlotLoad<1>{});
        if (RigidBody* body = std::get_if<RigidBody>(&system)) body->force = body->couple = {0, 0, 0};
    }
}

void Scene::run(std::span<const Step> steps) {
    for (RodProgram& rod : rods_) rod.prepare(steps);
    for (const auto& pass : passes_) pass->prepare(steps);
    for (const Step& step : steps) {
        // Within a step of several stages published codes add the loads of every stage to what the stages before have
        // left.
        if (step.index != step_) clear_loads();
        step_ = step.index;
        for (const RodProgram& rod : rods_) rod.move(step);
        for (const BodyProgram& body : bodies_) body.move(step);
        for (const Load& load : loads_) load(step);
        for (const RodProgram& rod : rods_) rod.kick(step);
        for (const BodyProgram& body : bodies_) body.kick(step);
    }
}

std::vector<Fields> Scene::fields(double lag, double time) const {
    std::vector<Fields> fields;
    auto rod = rods_.begin();
    auto body = bodies_.begin();
    for (const System& system : systems_) {
        if (const Rod* r = std::get_if<Rod>(&system)) fields.push_back(fields_of(*r, (rod++)->closed_state(lag, time)));
        else if (const RigidBody* b = std::get_if<RigidBody>(&system))
            fields.push_back(fields_of(*b, (body++)->closed_state(lag, time)));
        else fields.emplace_back();
    }
    return fields;
}

double Scene::largest_inv_length() const {
    double largest = 0;
    for (const System& system : systems_)
        if (const Rod* rod = std::get_if<Rod>(&system))
            for (const ElementConstants& c : rod->group.element) largest = std::max(largest, c.inv_rest_length);
    return largest;
}

double Scene::answering_stiffness() const {
    double largest = 0;
    for (const System& system : systems_)
        if (const Rod* rod = std::get_if<Rod>(&system); rod && answers_)
            for (const ElementConstants& c : rod->group.element)
                largest = std::max({largest, c.stiffness.x, c.stiffness.y, c.stiffness.z});
    return largest;
}

} // namespace skein::replay
