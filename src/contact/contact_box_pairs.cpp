// Contacts of two boxes.                                                                        theory.md (59f)-(59i)
//   normal    every feature that touches pushes with its own spring and dashpot, (g/G)^(4-m) T/x of the law, and what
//             changes with shares acts besides; m = 2 of the linear law, 5/2 of Hertz
//   friction  at the mean place of what pushes, in the plane across its mean normal, pressed by all of it; the spring
//             has a third component, the turn about the normal times the radius of what pushes
// Springs of friction turn with both bodies, as a face that is turned takes them along. The memory of dashpots is that
// of their sum at the mean place; what they take besides, as bodies rock or twist, is that of this step alone.
#include "contact/box_pair.hpp"
#include "contact/work_area.hpp"

#include <algorithm>

namespace skein {

namespace {

/// A box as it is exposed, with its rates.
struct MovingBox {
    PlacedBox placed;
    double radius;
    Vec3d velocity, spin;

    MovingBox(const Exposure& bodies, std::uint32_t slot, const PartBox& box, const Vec3d& origin)
        : placed(placed_box(bodies, slot, box, origin)), radius(box.radius), velocity(bodies.motion[slot].velocity),
          spin(bodies.motion[slot].spin) {}

    Vec3d velocity_at(const Vec3d& place) const { return velocity + cross(spin, place - placed.centre); }
};

/// Share of the law with which a feature pushes, by its overlap over that of the contact.
double share_of_law(ContactNormal normal, double depth) {
    return normal == ContactNormal::hertz ? depth * sqrt(depth) : depth * depth;
}

/// Sums over the features of a contact.
struct Pressed {
    BoxMeeting::Wrench load;
    Vec3d pushes{0, 0, 0};                  ///< force on the second, N
    Vec3d middle{0, 0, 0}, normal{0, 0, 0}; ///< mean place, m; of springs alone, a unit vector
    double radius = 0;                      ///< of what pushes, about the normal through the middle, m
    double viscous = 0;                     ///< force of dashpots along the normal, N
    double elastic_energy = 0, viscous_work = 0, stiffness = 0;
};

/// Mean place, normal and radius of what pushes, by springs.
void find_middle(const BoxMeeting& meeting, double radius_1, double radius_2, ContactNormal kind, Pressed& out) {
    const double all = meeting.overlap();
    const auto place_of = [&](const BoxMeeting::Touch& touch) {
        return fma(0.5 * (radius_1 - radius_2 + touch.gap.distance), touch.gap.normal, touch.gap.on_1);
    };
    const auto force_of = [&](const BoxMeeting::Touch& touch) {
        const double spring = kind == ContactNormal::hertz ? touch.overlap * sqrt(touch.overlap) : touch.overlap;
        return touch.share * share_of_law(kind, touch.overlap / all) * spring;
    };
    double sum = 0, moment = 0;
    for (const BoxMeeting::Touch& touch : meeting.touches()) {
        const double force = force_of(touch);
        sum += force;
        out.middle += force * place_of(touch);
        out.normal += force * touch.gap.normal;
    }
    out.middle = (1 / sum) * out.middle;
    out.normal = norm(out.normal) > 1e-9 * sum ? unit(out.normal) : meeting.touches().front().gap.normal;
    for (const BoxMeeting::Touch& touch : meeting.touches()) {
        const Vec3d arm = cross(place_of(touch) - out.middle, out.normal);
        moment = fma(force_of(touch), dot(arm, arm), moment);
    }
    out.radius = sqrt(moment / sum);
}

/// Normal forces of all features.
Pressed press(const BoxMeeting& meeting, const MovingBox& one, const MovingBox& two, ContactNormal kind,
              const ContactNumbers<Pack<1>>& law, double h) {
    using Q = Pack<1>;
    Pressed out;
    find_middle(meeting, one.radius, two.radius, kind, out);
    const double all = meeting.overlap();
    double slopes = 0;
    for (const BoxMeeting::Touch& touch : meeting.touches()) {
        const BoxGap& gap = touch.gap;
        const ContactState<Q> state{broadcast<1>(gap.normal),
                                    gap.distance,
                                    one.radius,
                                    two.radius,
                                    broadcast<1>(one.velocity_at(gap.on_1)),
                                    broadcast<1>(one.spin),
                                    broadcast<1>(two.velocity_at(gap.on_2)),
                                    broadcast<1>(two.spin)};
        const double depth = touch.overlap / all;
        const Q weight(touch.share * share_of_law(kind, depth));
        ContactMemory<Q> none{};
        const auto f = contact_force<1>({kind, ContactFriction::none}, law, state, h, none, {weight, weight});
        out.load.add(gap, one.placed.centre, two.placed.centre, f.normal[0]);
        out.elastic_energy += f.elastic_energy[0];
        out.viscous_work += 2 * f.viscous_work[0];
        const double root = kind == ContactNormal::hertz ? sqrt(touch.overlap) : 1.0;
        out.viscous +=
            (f.normal[0] - weight[0] * root * law.stiffness[0] * touch.overlap) * dot(gap.normal, out.normal);
        out.stiffness = std::max(out.stiffness, f.stiffness[0]);
        slopes = fma(depth, depth, slopes);
    }
    if (meeting.touches().size() > 1) out.stiffness *= 3 * slopes;
    const double change = law.stiffness[0] / (kind == ContactNormal::hertz ? all * sqrt(all) : all * all);
    const BoxMeeting::Wrench& shares = meeting.change();
    out.load.force += change * shares.force;
    out.load.couple_1 += change * shares.couple_1;
    out.load.couple_2 += change * shares.couple_2;
    out.pushes = -out.load.force;
    return out;
}

/// Adds friction at the middle of what pushes. `memory` becomes that of this step.
void rub(const Pressed& pressed, const BoxMeeting& meeting, const MovingBox& one, const MovingBox& two,
         ContactKinds kinds, const ContactNumbers<Pack<1>>& law, double h, ContactMemory<Pack<1>>& memory,
         BoxMeeting::Wrench& load, ContactForce<Pack<1>>& out) {
    using Q = Pack<1>;
    const Vec3d &n = pressed.normal, slip = one.velocity_at(pressed.middle) - two.velocity_at(pressed.middle),
                both = one.spin + two.spin,
                rate = fma(pressed.radius * dot(one.spin - two.spin, n) - dot(slip, n), n, slip);
    const double all = meeting.overlap(), wide = pressed.radius * pressed.radius / ((one.radius + two.radius) * all);
    const detail::SlidingPatch<1> sliding{{broadcast<1>(n), broadcast<1>(rate), broadcast<1>(0.5 * h * rate), Q(h),
                                           Q(0.0), Q(std::max(0.0, dot(pressed.pushes, n))),
                                           Q(kinds.normal == ContactNormal::hertz ? sqrt(all) : 1.0), Q(1.0),
                                           Q(0.0) < Q(1.0)},
                                          broadcast<1>(0.5 * h * both),
                                          Q(std::min(1.0, wide))};
    const double approach = dot(slip, n), before = -dot(lane(memory.viscous_part, 0), n);
    memory.viscous_part += broadcast<1>(before * n);
    const auto friction = detail::add_friction<1>(kinds, law, sliding, memory, nullptr, out);
    memory = friction.memory;
    const double twisting = dot(lane(memory.viscous_part, 0), n), taken = -0.5 * h * dot(rate, n) * twisting;
    (kinds.friction == ContactFriction::memory ? out.viscous_work : out.friction_work) += Q(taken);
    out.viscous_work += 0.5 * h * approach * (before - pressed.viscous);
    memory.viscous_part -= broadcast<1>((twisting + pressed.viscous) * n);
    const Vec3d force = lane(friction.force, 0), twist = dot(force, n) * n, along = force - twist,
                couple = pressed.radius * twist;
    load.force += along;
    load.couple_1 += cross(pressed.middle - one.placed.centre, along) + couple;
    load.couple_2 -= cross(pressed.middle - two.placed.centre, along) + couple;
}

} // namespace

/// `now`: the memory of the contact, in place of the one that a step moves on. The first box is the element.
Contacts::BoxContact Contacts::evaluate_boxes(const Exposure& bodies, double h, std::uint32_t number,
                                              const ContactMemory<double>* now) const {
    const auto [a, b] = list_.pair[number];
    const Vec3d& origin = bodies.node[a].position;
    const MovingBox one(bodies, a, *box_at(bodies, a), origin), two(bodies, b, *box_at(bodies, b), origin);
    const BoxMeeting meeting(one.placed, two.placed, one.radius + two.radius);
    BoxContact out;
    out.overlap = meeting.deepest();
    out.diameter = 2 * std::min(one.radius, two.radius);
    out.touches = meeting.overlap() > 0;
    out.intersect = separation(one.placed, two.placed, false) < 0 && separation(one.placed, two.placed, true) < 0;
    if (!out.touches) return out;
    const ContactNumbers<Pack<1>> law = numbers<1>(bodies, &list_.pair[number]);
    Pressed pressed = press(meeting, one, two, kinds_.normal, law, h);
    out.normal = pressed.normal;
    out.place = origin + pressed.middle;
    out.slip = one.velocity_at(pressed.middle) - two.velocity_at(pressed.middle);
    out.force.elastic_energy = pressed.elastic_energy;
    out.force.viscous_work = pressed.viscous_work;
    out.force.stiffness = pressed.stiffness;
    out.force.friction_work = 0.0;
    ContactMemory<Pack<1>> memory{};
    if (now) memory.spring = {broadcast<1>(now->spring.x), now->spring.stiffness};
    else if (remembers_ && status_[number] & touching) set_lane(memory, 0, memory_[number]);
    rub(pressed, meeting, one, two, kinds_, law, h, memory, pressed.load, out.force);
    out.memory = lane(memory, 0);
    out.on_element = {pressed.load.force, {0, 0, 0}, pressed.load.couple_1};
    out.on_box = {-pressed.load.force, {0, 0, 0}, pressed.load.couple_2};
    return out;
}

} // namespace skein
