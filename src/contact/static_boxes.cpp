#include "contact/static_boxes.hpp"

#include "contact/box_pair.hpp"
#include "contact/segment_meeting.hpp"

namespace skein {

namespace {

using P = Pack<dual>;
using V = Vec3<P>;
using Parts = BoxContactAtRest::Parts;

constexpr double zero = 0, one = 1;

V unit_of(const V& a) { return (one / norm(a)) * a; }
/// depth^whole, with half a power more of Hertz.
P power(ContactNormal kind, const P& depth, int whole) {
    P all = kind == ContactNormal::hertz ? sqrt(depth) : P(one);
    for (int i = 0; i < whole; ++i) all = all * depth;
    return all;
}

/// Place, direction and size of the normal force of a contact.
struct Pushes {
    V middle{zero, zero, zero}, normal = middle; ///< mean place; from 1 to 2, a unit vector
    P pressed = zero, radius = zero;             ///< along the normal, N; of what pushes about it, m
    P depth = zero;                              ///< overlap that the stiffness of friction belongs to, m
};

BoxInPlace<P> placed(const MovedElement& element, const AttachedSlot& slot, const V& origin) {
    const auto axis = [&](const Vec3d& of_box) {
        return transpose_times(element.frame, constant<P>(transpose_times(slot.box->axes, of_box)));
    };
    return {element.start() - origin, {axis({1, 0, 0}), axis({0, 1, 0}), axis({0, 0, 1})}, slot.box->half};
}

/// Loads on both nodes of an element and a couple, lab, as those of its slots `row` and the next one.
void put(const MovedElement& element, std::size_t row, const V& first, const V& second, const V& couple,
         ElementLoads& out) {
    out.force[row] = first;
    out.force[row + 1] = second;
    out.couple[row] = element.frame * (cross(element.arm[0], first) + couple);
    out.couple[row + 1] = element.frame * cross(element.arm[1], second);
}

/// Friction of a contact at its mean place.
template <class S> V friction_of(ContactKinds kinds, const ContactNumbers<P>& law, const S& sliding,
                                 const FrictionSpring<double>& spring) {
    ContactMemory<P> memory{{constant<P>(spring.x), P(spring.stiffness)}, {zero, zero, zero}, zero};
    ContactForce<P> works;
    works.viscous_work = works.elastic_energy = zero;
    return detail::add_friction<dual>(kinds, law, sliding, memory, nullptr, works).force;
}

/// An element, which is body 1 of the law, and a box.
class ElementAtBox {
public:
    ElementAtBox(const BoxContactAtRest& contact, const MovedElement& element, const MovedElement& box, int number)
        : contact_(contact), element_(element), moved_box_(box), number_(static_cast<std::size_t>(number)),
          law_(contact.numbers.as<P>()), centre_(box.start()), box_(placed(box, *contact.slot[1 - number_], centre_)),
          meeting_({box_.axes * (element.start() - centre_),
                    box_.axes * element.edge(),
                    {contact.shares[0], contact.shares[1]}},
                   box_.half, contact.radius[0] + contact.radius[1], contact.kinds.normal) {}

    BoxLoads loads(double step, Parts parts) {
        BoxLoads out;
        const bool touches = value_of(meeting_.energy()) > 0;
        out.overlap = touches ? value_of(meeting_.deepest()) : 0;
        if (touches) {
            press(step);
            if (parts == Parts::friction) first_ = second_ = couple_ = box_couple_ = {zero, zero, zero};
            if (parts != Parts::springs && contact_.spring) rub(step);
        }
        out.energy = contact_.numbers.stiffness * value_of(meeting_.energy());
        out.share[number_] = value_of(s_);
        put(element_, 2 * number_, first_, second_, couple_, out);
        put(moved_box_, 2 - 2 * number_, -(first_ + second_), {zero, zero, zero}, box_couple_, out);
        return out;
    }

private:
    using Meeting = MeetingOfSegment<P>;

    V to_lab(const V& in_box) const { return transpose_times(box_.axes, in_box); }
    V box_velocity_at(const V& arm) const { return moved_box_.velocity(zero) + cross(moved_box_.spin, arm); }
    void exert(const P& s, const V& force, const V& arm) {
        first_ += (one - s) * force;
        second_ += s * force;
        box_couple_ -= cross(arm, force);
    }

    void press(double step) {
        const double radius = contact_.radius[number_], of_box = contact_.radius[1 - number_];
        P sum = zero;
        for (const Meeting::Touch& touch : meeting_.touches()) {
            const V normal = -to_lab(touch.gap.outwards), arm = to_lab(touch.gap.on_box);
            const ContactState<P> state{
                normal,        touch.gap.distance,   P(radius),      P(of_box), element_.velocity(touch.gap.s),
                element_.spin, box_velocity_at(arm), moved_box_.spin};
            ContactMemory<P> none{{{zero, zero, zero}, zero}, {zero, zero, zero}, zero};
            const ContactForce<P> f = contact_force<dual>({contact_.kinds.normal, ContactFriction::none}, law_, state,
                                                          step, none, {touch.share, touch.share});
            const P spring = touch.share * Meeting::force_of(contact_.kinds.normal, touch.overlap);
            exert(touch.gap.s, -f.normal * normal, arm);
            sum += spring;
            s_ += spring * touch.gap.s;
            mean_.normal += spring * normal;
            mean_.middle += spring * (arm - (of_box - 0.5 * touch.overlap) * normal);
        }
        s_ = s_ / sum;
        mean_.middle = (one / sum) * mean_.middle;
        mean_.normal = value_of(norm(mean_.normal)) > 1e-9 * value_of(sum)
                           ? unit_of(mean_.normal)
                           : -to_lab(meeting_.touches().front().gap.outwards);
        const Meeting::Load& change = meeting_.change();
        first_ += law_.stiffness * to_lab(change.first);
        second_ += law_.stiffness * to_lab(change.second);
        box_couple_ += law_.stiffness * to_lab(change.couple);
        mean_.pressed = max(zero, -dot(first_ + second_, mean_.normal));
    }

    void rub(double step) {
        const V &n = mean_.normal, on_axis = element_.point(s_) - centre_, arm = mean_.middle - on_axis,
                all = element_.velocity(s_) + cross(element_.spin, arm) - box_velocity_at(mean_.middle),
                slip = all - dot(all, n) * n;
        const ContactNormal kind = contact_.kinds.normal;
        const P weight =
            contact_.weight > 0 ? P(contact_.weight) : meeting_.energy() / Meeting::energy_of(kind, meeting_.deepest());
        const P half(0.5 * step);
        const detail::Sliding<dual> sliding{n,
                                            slip,
                                            half * slip,
                                            P(step),
                                            half * dot(element_.spin + moved_box_.spin, n),
                                            mean_.pressed,
                                            power(kind, meeting_.deepest(), 0),
                                            weight,
                                            Mask<dual>{true}};
        const V force = friction_of(contact_.kinds, law_, sliding, *contact_.spring);
        exert(s_, force, mean_.middle);
        couple_ += cross(arm, force);
    }

    const BoxContactAtRest& contact_;
    const MovedElement &element_, &moved_box_;
    const std::size_t number_; ///< of the element in its pair
    const ContactNumbers<P> law_;
    const V centre_; ///< of the box, from which places are
    const BoxInPlace<P> box_;
    const Meeting meeting_;
    P s_ = zero;
    Pushes mean_;
    V first_{zero, zero, zero}, second_ = first_, couple_ = first_, box_couple_ = first_; ///< lab
};

/// Two boxes; places are from the first one's centre.
class TwoBoxes {
public:
    TwoBoxes(const BoxContactAtRest& contact, const MovedElement& a, const MovedElement& b)
        : contact_(contact), one_(a), two_(b), law_(contact.numbers.as<P>()), origin_(a.start()),
          first_(placed(a, *contact.slot[0], origin_)), second_(placed(b, *contact.slot[1], origin_)),
          meeting_(first_, second_, contact.radius[0] + contact.radius[1]) {}

    BoxLoads loads(double step, Parts parts) {
        BoxLoads out;
        if (value_of(meeting_.overlap()) > 0) {
            out.overlap = value_of(meeting_.deepest());
            out.energy = value_of(normal_energy(contact_.kinds.normal, law_.stiffness, meeting_.overlap()));
            find_middle();
            press(step);
            if (parts == Parts::friction) load_ = {};
            if (parts != Parts::springs && contact_.spring) rub(step);
        }
        put(one_, 0, load_.force, {zero, zero, zero}, load_.couple_1, out);
        put(two_, 2, -load_.force, {zero, zero, zero}, load_.couple_2, out);
        return out;
    }

private:
    using Meeting = MeetingOfBoxes<P>;

    V velocity_1(const V& place) const { return one_.velocity(zero) + cross(one_.spin, place - first_.centre); }
    V velocity_2(const V& place) const { return two_.velocity(zero) + cross(two_.spin, place - second_.centre); }
    V place_of(const Meeting::Touch& touch) const {
        const P share = 0.5 * (contact_.radius[0] - contact_.radius[1] + touch.gap.distance);
        return fma(share, touch.gap.normal, touch.gap.on_1);
    }
    /// Share of the law with which a feature pushes.
    P weight_of(const Meeting::Touch& touch) const {
        const P depth = touch.overlap / meeting_.overlap();
        return touch.share * power(contact_.kinds.normal, depth, contact_.kinds.normal == ContactNormal::hertz ? 1 : 2);
    }

    void find_middle() {
        const auto force_of = [&](const Meeting::Touch& touch) {
            return weight_of(touch) * power(contact_.kinds.normal, touch.overlap, 1);
        };
        P sum = zero, moment = zero;
        for (const Meeting::Touch& touch : meeting_.touches()) {
            const P force = force_of(touch);
            sum += force;
            mean_.middle += force * place_of(touch);
            mean_.normal += force * touch.gap.normal;
        }
        mean_.middle = (one / sum) * mean_.middle;
        mean_.normal = value_of(norm(mean_.normal)) > 1e-9 * value_of(sum) ? unit_of(mean_.normal)
                                                                           : meeting_.touches().front().gap.normal;
        for (const Meeting::Touch& touch : meeting_.touches()) {
            const V arm = cross(place_of(touch) - mean_.middle, mean_.normal);
            moment += force_of(touch) * dot(arm, arm);
        }
        mean_.radius = sqrt(moment / sum);
    }

    void press(double step) {
        for (const Meeting::Touch& touch : meeting_.touches()) {
            const ContactState<P> state{
                touch.gap.normal,           touch.gap.distance, P(contact_.radius[0]),      P(contact_.radius[1]),
                velocity_1(touch.gap.on_1), one_.spin,          velocity_2(touch.gap.on_2), two_.spin};
            const P weight = weight_of(touch);
            ContactMemory<P> none{{{zero, zero, zero}, zero}, {zero, zero, zero}, zero};
            const ContactForce<P> f = contact_force<dual>({contact_.kinds.normal, ContactFriction::none}, law_, state,
                                                          step, none, {weight, weight});
            load_.add(touch.gap, first_.centre, second_.centre, f.normal);
        }
        const P& all = meeting_.overlap();
        const P change = contact_.kinds.normal == ContactNormal::hertz ? law_.stiffness / (all * sqrt(all))
                                                                       : law_.stiffness / (all * all);
        const Meeting::Wrench& shares = meeting_.change();
        load_.force += change * shares.force;
        load_.couple_1 += change * shares.couple_1;
        load_.couple_2 += change * shares.couple_2;
        mean_.pressed = max(zero, -dot(load_.force, mean_.normal));
    }

    void rub(double step) {
        const V &n = mean_.normal, slip = velocity_1(mean_.middle) - velocity_2(mean_.middle),
                both = one_.spin + two_.spin;
        const P twist_rate = mean_.radius * dot(one_.spin - two_.spin, n), half(0.5 * step),
                wide = mean_.radius * mean_.radius / ((contact_.radius[0] + contact_.radius[1]) * meeting_.overlap());
        const V rate = fma(twist_rate - dot(slip, n), n, slip);
        const detail::SlidingPatch<dual> sliding{{n, rate, half * rate, P(step), zero, mean_.pressed,
                                                  power(contact_.kinds.normal, meeting_.overlap(), 0), one,
                                                  Mask<dual>{true}},
                                                 half * both,
                                                 min(one, wide)};
        const V force = friction_of(contact_.kinds, law_, sliding, *contact_.spring);
        const V twist = dot(force, n) * n, along = force - twist, couple = mean_.radius * twist;
        load_.force += along;
        load_.couple_1 += cross(mean_.middle - first_.centre, along) + couple;
        load_.couple_2 -= cross(mean_.middle - second_.centre, along) + couple;
    }

    const BoxContactAtRest& contact_;
    const MovedElement &one_, &two_;
    const ContactNumbers<P> law_;
    const V origin_;
    const BoxInPlace<P> first_, second_;
    const Meeting meeting_;
    Pushes mean_;
    Meeting::Wrench load_;
};

} // namespace

BoxLoads BoxContactAtRest::load(const MovedElement& a, const MovedElement& b, double step, Parts parts) const {
    if (slot[0]->box && slot[1]->box) return TwoBoxes(*this, a, b).loads(step, parts);
    return slot[0]->box ? ElementAtBox(*this, b, a, 1).loads(step, parts)
                        : ElementAtBox(*this, a, b, 0).loads(step, parts);
}

BoxPairAtRest box_contact_at(const Exposure& bodies, std::span<const AttachedSlot> attached, Pair pair,
                             std::span<const Slot<1>> state, std::span<const Slot<1>> then, ContactKinds kinds,
                             const ContactNumbers<double>& numbers) {
    const auto radius_of = [&](std::uint32_t e) {
        return attached[e].box ? attached[e].box->radius : bodies.node[e].radius;
    };
    const auto element_at = [&](std::uint32_t e) {
        const AttachedSlot *first = &attached[e], *second = &attached[e + 1];
        return ElementAtRest{{first, second},
                             {&state[first->slot], &state[second->slot]},
                             {&then[first->slot], &then[second->slot]},
                             radius_of(e)};
    };
    const unsigned vertices = bodies.vertices[attached[pair.a].box ? pair.b : pair.a];
    return {{kinds,
             numbers,
             {&attached[pair.a], &attached[pair.b]},
             {radius_of(pair.a), radius_of(pair.b)},
             {vertices & at_start ? 0.5 : 1.0, vertices & at_end ? 0.5 : 1.0}},
            {element_at(pair.a), element_at(pair.b)}};
}

} // namespace skein
