#include "contact/static_boxes.hpp"
// The above comes before all templates over packs.
#include "contact/static_contacts.hpp"
#include "contact/static_friction.hpp"
#include "core/closest_points.hpp"

#include <algorithm>
#include <utility>

namespace skein {

namespace {

bool before(const SavedContact& x, const SavedContact& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); }

struct RubbingContact {
    using P = Pack<dual>;

    ContactKinds kinds;
    const ContactNumbers<double>& numbers;
    const Contact& contact;
    FrictionSpring<double> spring;
    double nearest[2]; ///< shares of the nearest points, which vertices move

    /// Friction over a step, s, or with the normal force too.
    ElementLoads load(const MovedElement& a, const MovedElement& b, double step, bool with_normal) const {
        const ClosestPoints<P> at = closest_points(a.start(), a.edge(), b.start(), b.edge());
        const P s = at.s + P(contact.s - nearest[0]), t = at.t + P(contact.t - nearest[1]);
        const Vec3<P> apart = b.point(t) - a.point(s);
        const P distance = norm(apart), radius_1(radius[0]), radius_2(radius[1]);
        const Vec3<P> n = (P(1.0) / distance) * apart;
        const ContactState<P> state{n, distance, radius_1, radius_2, a.velocity(s), a.spin, b.velocity(t), b.spin};
        ContactMemory<P> memory{
            {broadcast<dual>(spring.x), P(spring.stiffness)}, broadcast<dual>(Vec3d{0, 0, 0}), P(0.0)};
        const P weight(contact.weight);
        const ContactForce<P> all =
            contact_force<dual>(kinds, numbers.as<P>(), state, step, memory, {weight, weight}, P(elsewhere));
        const Vec3<P> force = with_normal ? all.on_1 : all.on_1 + all.normal * n;
        ElementLoads load{{(P(1.0) - s) * force, s * force, (t - P(1.0)) * force, -t * force}, {}};
        for (const int i : {0, 1, 2, 3}) {
            const MovedElement& of = i < 2 ? a : b;
            Vec3<P> moment = cross(of.arm[i % 2], load.force[i]);
            if (i == 0) moment = moment + all.arm_1 * all.moment;
            if (i == 2) moment = moment + all.arm_2 * all.moment;
            load.couple[i] = of.frame * moment;
        }
        return load;
    }

    double radius[2];
    double elsewhere; ///< normal force at the contact's other points, N
};

} // namespace

StaticFriction::StaticFriction(const ContactScene& scene, std::span<const RodGroup> groups,
                               std::span<const LocalRod> rods, const Threads& threads)
    : scene_(scene), groups_(groups), rods_(rods.begin(), rods.end()), threads_(threads) {
    scene_.laws = scene_.laws.sticking_at_limit();
}

void StaticFriction::set_springs(std::vector<SavedContact> springs) {
    springs_ = std::move(springs);
    std::sort(springs_.begin(), springs_.end(), before);
    left_ = springs_;
}

void StaticFriction::show_rates(Exposure& bodies, std::span<const Slot<1>> state, std::span<const Slot<1>> then) const {
    std::vector<Slot<1>> one;
    std::size_t first = 0;
    for (std::size_t i = 0; i < rods_.size(); ++i) {
        const RodGroup& group = nth(groups_, rods_[i].group);
        const std::size_t slots = to_index(group.slots());
        one.assign(state.begin() + static_cast<std::ptrdiff_t>(first),
                   state.begin() + static_cast<std::ptrdiff_t>(first + slots));
        set_rates_from(then.subspan(first, slots), one);
        first += slots;
        if (group.closed()) one.back() = one.front();
        bodies.show(i, one, group.body());
    }
}

void StaticFriction::take_loads(const Exposure& bodies, std::span<const AttachedSlot> attached,
                                std::span<const Slot<1>> state, const SlotLoads& loads, StaticContactLoads& out) const {
    for (std::size_t s = 0; s < bodies.slots(); ++s) {
        if (!nth(loads.touched, bodies.window_of[s])) continue;
        const ExertedLoad& load = loads.load[s];
        const AttachedSlot& at = attached[s];
        const Quaterniond frame = lane(state[at.slot].director, 0);
        out.force[at.slot] += load.force;
        if (bodies.has_element(s)) out.couple[at.slot] += frame * load.couple;
        if (at.on_body) out.couple[at.slot] += cross(at.arm, frame * load.force);
    }
}

FrictionSpring<double> StaticFriction::spring_before(const Exposure& bodies, std::span<const AttachedSlot> attached,
                                                     const Contact& contact, const SavedContact& left) const {
    const SavedContact key{bodies.in_scene(contact.pair.a), bodies.in_scene(contact.pair.b), 0, {}};
    const auto at = std::lower_bound(springs_.begin(), springs_.end(), key, before);
    if (at != springs_.end() && !before(key, *at)) return at->memory.spring;
    if (attached[contact.pair.a].box && attached[contact.pair.b].box) return {{0, 0, 0}, 0};
    // A new contact's may be that of its neighbour: what is left without the way, if it sticks. What slides has none.
    const double sign = attached[contact.pair.a].box ? -1 : 1; // an element at a box is the first of the law
    const Vec3d &n = contact.normal, way = sign * long_step * (contact.slip - dot(contact.slip, n) * n);
    FrictionSpring<double> spring = left.memory.spring;
    constexpr double sticks = 1 - 1e-9;
    spring.x = norm(spring.x) < sticks * norm(way) ? Vec3d{0, 0, 0} : spring.x - way;
    return spring;
}

void StaticFriction::add(Exposure& bodies, std::span<const AttachedSlot> attached, std::span<const Slot<1>> state,
                         double time, bool with_stiffness, StaticContactLoads& out) {
    show_rates(bodies, state, reference_);
    const std::vector<ContactNumbers<double>> numbers = scene_.laws.numbers(time);
    const std::unique_ptr<ContactSolver> solver = make_contacts(scene_, threads_);
    const BinnedTotal none(solver->energy_bins());
    solver->restore(springs_, none, none);
    SlotLoads loads;
    solver->evaluate(bodies, time, long_step, loads);
    left_ = solver->saved(bodies);
    take_loads(bodies, attached, state, loads, out);
    const std::vector<Contact> all = solver->active(bodies); // in the order of left_
    for (std::size_t c = 0; c < all.size(); ++c) {
        const ContactMemory<double>& memory = left_[c].memory;
        const double friction = memory.weight * memory.spring.stiffness * norm(memory.spring.x);
        for (const std::uint32_t element : {all[c].pair.a, all[c].pair.b})
            out.couple_size[attached[element].slot] += bodies.node[element].radius * friction;
        const auto asked = [&](std::uint32_t element) { return out.share.has(attached[element].slot); };
        if (with_stiffness && (asked(all[c].pair.a) || asked(all[c].pair.b)))
            add_slopes_of(Slopes::by_places, bodies, attached, state, reference_, numbers, all[c], left_[c], out);
    }
}

bool StaticFriction::damps(double time) const {
    const std::vector<ContactNumbers<double>> numbers = scene_.laws.numbers(time);
    const ContactFriction friction = scene_.laws.friction();
    return std::any_of(numbers.begin(), numbers.end(), [&](const ContactNumbers<double>& law) {
        return law.damping > 0 || (friction == ContactFriction::memory && law.tangential_damping > 0) ||
               (slips_always(friction) && law.kinetic_friction > 0);
    });
}

void StaticFriction::add_damping(Exposure& bodies, std::span<const AttachedSlot> attached,
                                 std::span<const Slot<1>> state, double time, StaticContactLoads& out) {
    show_rates(bodies, state, state);
    std::vector<ContactNumbers<double>> numbers = scene_.laws.numbers(time);
    for (ContactNumbers<double>& law : numbers) law.twice_step = 1; // of regularised friction without a spring
    const std::unique_ptr<ContactSolver> solver = make_contacts(scene_, threads_);
    const BinnedTotal none(solver->energy_bins());
    solver->restore(springs_, none, none);
    SlotLoads loads;
    solver->evaluate(bodies, time, long_step, loads);
    const std::vector<Contact> all = solver->active(bodies);
    std::vector<SavedContact> left = solver->saved(bodies);
    left.resize(all.size()); // none where contacts have no memory
    for (std::size_t c = 0; c < all.size(); ++c)
        add_slopes_of(Slopes::by_rates, bodies, attached, state, state, numbers, all[c], left[c], out);
}

void StaticFriction::add_slopes_of(Slopes by, const Exposure& bodies, std::span<const AttachedSlot> attached,
                                   std::span<const Slot<1>> state, std::span<const Slot<1>> then,
                                   std::span<const ContactNumbers<double>> numbers, const Contact& one,
                                   const SavedContact& left, StaticContactLoads& out) const {
    const auto [a, b] = one.pair;
    const auto material = [&](std::uint32_t slot) { return to_index(bodies.at(slot).group); };
    const std::size_t law = scene_.laws.materials() == 1 ? 0 : material(a) * scene_.laws.materials() + material(b);
    const ContactNumbers<double> of_pair = scene_.for_bodies(numbers[law], bodies.at(a), bodies.at(b));
    const ContactKinds kinds{scene_.laws.normal(), scene_.laws.friction()};
    const FrictionSpring<double> spring = slips_always(kinds.friction) ? FrictionSpring<double>{{0, 0, 0}, 0}
                                                                       : spring_before(bodies, attached, one, left);
    const double step = by == Slopes::by_rates ? 0 : long_step;
    if (attached[a].box || attached[b].box) {
        auto [contact, element] = box_contact_at(bodies, attached, one.pair, state, then, kinds, of_pair);
        const bool joined = bodies.vertices[attached[a].box ? b : a] & (at_start | at_end);
        contact.weight = joined ? one.weight : 0;
        contact.spring = &spring;
        const auto parts = by == Slopes::by_rates ? BoxContactAtRest::Parts::all : BoxContactAtRest::Parts::friction;
        add_slopes_of_loads(
            by, element,
            [&, &contact = contact](const MovedElement& first, const MovedElement& second) {
                return contact.load(first, second, step, parts);
            },
            out.turning);
        return;
    }
    const auto element_at = [&](std::uint32_t e) {
        const AttachedSlot *first = &attached[e], *second = &attached[e + 1];
        return ElementAtRest{{first, second},
                             {&state[first->slot], &state[second->slot]},
                             {&then[first->slot], &then[second->slot]},
                             bodies.node[e].radius};
    };
    const ElementAtRest element[2] = {element_at(a), element_at(b)};
    const auto nearest = closest_points(
        broadcast<1>(bodies.node[a].position), broadcast<1>(bodies.node[a + 1].position - bodies.node[a].position),
        broadcast<1>(bodies.node[b].position), broadcast<1>(bodies.node[b + 1].position - bodies.node[b].position));
    const double pressed = -dot(one.force, one.normal), depth = std::max(one.overlap, 0.0),
                 own = one.weight * of_pair.stiffness * depth *
                       (scene_.laws.normal() == ContactNormal::hertz ? std::sqrt(depth) : 1.0);
    const RubbingContact contact{kinds,
                                 of_pair,
                                 one,
                                 spring,
                                 {nearest.s[0], nearest.t[0]},
                                 {element[0].radius, element[1].radius},
                                 std::max(0.0, pressed - own)};
    add_slopes_of_loads(
        by, element,
        [&](const MovedElement& first, const MovedElement& second) {
            return contact.load(first, second, step, by == Slopes::by_rates);
        },
        out.turning);
}

} // namespace skein
