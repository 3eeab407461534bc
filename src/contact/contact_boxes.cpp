// Contacts of elements with boxes, one by one, after those of the block's capsules. The order of both depends on the
// scene alone. The candidate of a box is the ball around it.                                            theory.md (59e)
//   normal    every feature that touches pushes with its own spring and dashpot, its share T/x of the law, and what
//             changes with shares acts besides
//   friction  at the mean place of what pushes, across its mean normal, pressed by all of it
// The memory of dashpots is that of their sum along the mean normal; what they take besides, as an element rocks, is
// that of this step alone. Two boxes: contact_box_pairs.cpp.
#include "contact/contact_tangent.hpp"
#include "contact/segment_meeting.hpp"
#include "contact/work_area.hpp"
#include "skein/core/index.hpp"

#include <algorithm>

namespace skein {

/// Box that an exposed element is, or null.
const PartBox* Contacts::box_at(const Exposure& bodies, std::uint32_t slot) const {
    const auto group = to_index(bodies.at(slot).group);
    if (group >= scene_.boxes.size() || scene_.boxes[group].empty()) return nullptr;
    const PartBox& part = scene_.boxes[group][to_index(bodies.element(slot)) / 2];
    return part.radius > 0 ? &part : nullptr;
}

/// True where a pair's first is the box of an element, and not the first of two boxes.
bool Contacts::box_is_first(const Exposure& bodies, std::uint32_t pair) const {
    return box_at(bodies, list_.pair[pair].a) && !box_at(bodies, list_.pair[pair].b);
}

/// Finds the pairs of the list that have a box.
void Contacts::find_boxes(const Exposure& bodies) {
    box_pairs_.clear();
    has_box_.clear();
    if (scene_.boxes.empty()) return;
    for (std::uint32_t i = 0; i < list_.count(); ++i)
        if (box_at(bodies, list_.pair[i].a) || box_at(bodies, list_.pair[i].b)) box_pairs_.push_back(i);
    if (box_pairs_.empty()) return;
    has_box_.assign(list_.count() + PairList::padding, 0);
    for (const std::uint32_t i : box_pairs_) has_box_[i] = 1;
}

/// An element and a box that it may touch, as they are exposed. The element is body 1 of the law.
class Contacts::BoxPair {
public:
    BoxPair(const Exposure& bodies, std::uint32_t element, std::uint32_t box_slot, const PartBox& box)
        : bodies(bodies), element(element), box(box), node(&bodies.node[element]), motion(&bodies.motion[element]),
          box_motion(&bodies.motion[box_slot]),
          centre(bodies.node[box_slot].position), axes{box_motion[1].velocity, box_motion[1].spin,
                                                       cross(box_motion[1].velocity, box_motion[1].spin)} {}

    double reach() const { return node->radius + box.radius; }
    SegmentMeeting meeting(ContactNormal normal) const { return meeting_of(element, normal); }
    /// The same of another element of the rod.
    SegmentMeeting meeting_of(std::uint32_t slot, ContactNormal normal) const {
        const unsigned vertices = bodies.vertices[slot];
        const Vec3d &from = bodies.node[slot].position, &to = bodies.node[slot + 1].position;
        return {{axes * (from - centre),
                 axes * (to - from),
                 {vertices & at_start ? 0.5 : 1.0, vertices & at_end ? 0.5 : 1.0}},
                box.half,
                bodies.node[slot].radius + box.radius,
                normal};
    }
    Vec3d to_lab(const Vec3d& in_box) const { return transpose_times(axes, in_box); }
    /// On the axis of the element, from the box's centre.
    Vec3d axis_at(double s) const { return node[0].position + s * (node[1].position - node[0].position) - centre; }
    Vec3d velocity_at(double s) const { return motion[0].velocity + s * (motion[1].velocity - motion[0].velocity); }
    Vec3d box_velocity_at(const Vec3d& arm) const { return box_motion->velocity + cross(box_motion->spin, arm); }

    const Exposure& bodies;
    const std::uint32_t element;
    const PartBox& box;
    const ExposedNode* const node; ///< start and end of the element
    const ExposedMotion *const motion, *const box_motion;
    const Vec3d centre; ///< centre of the box, m
    const Mat3d axes;   ///< axes of the box, as neighbourhood/surface.hpp exposes them
};

/// Features of an element at a box together; places from the box's centre, lab.
struct Contacts::BoxPressure {
    double s = 0;                           ///< mean share of the element
    Vec3d middle{0, 0, 0}, normal{0, 0, 0}; ///< mean place, m; from the element to the box, a unit vector
    double pressed = 0, viscous = 0;        ///< along the normal: force of all, and that of dashpots, N
};

/// Adds the normal forces of all features, and finds their mean by what their springs bear.
Contacts::BoxPressure Contacts::press_on_box(const BoxPair& pair, const SegmentMeeting& meeting,
                                             const ContactNumbers<Pack<1>>& law, double h, BoxContact& out) const {
    BoxPressure mean;
    double sum = 0;
    Vec3d viscous{0, 0, 0};
    for (const SegmentMeeting::Touch& touch : meeting.touches()) {
        const SegmentMeeting::Gap& gap = touch.gap;
        const Vec3d normal = -pair.to_lab(gap.outwards), arm = pair.to_lab(gap.on_box);
        const ContactState<Pack<1>> state{broadcast<1>(normal),
                                          gap.distance,
                                          pair.node->radius,
                                          pair.box.radius,
                                          broadcast<1>(pair.velocity_at(gap.s)),
                                          broadcast<1>(pair.motion->spin),
                                          broadcast<1>(pair.box_velocity_at(arm)),
                                          broadcast<1>(pair.box_motion->spin)};
        ContactMemory<Pack<1>> none{};
        const Pack<1> share(touch.share);
        const auto f = contact_force<1>({kinds_.normal, ContactFriction::none}, law, state, h, none, {share, share});
        const double push = f.normal[0],
                     spring = touch.share * SegmentMeeting::force_of(kinds_.normal, touch.overlap); // over k
        out.exert(gap.s, -push * normal, arm);
        out.force.elastic_energy += f.elastic_energy;
        out.force.viscous_work += f.viscous_work + f.viscous_work; // of a step with this force
        out.force.stiffness = max(out.force.stiffness, f.stiffness);
        viscous += (push - law.stiffness[0] * spring) * normal;
        sum += spring;
        mean.s += spring * gap.s;
        mean.normal += spring * normal;
        mean.middle += spring * (arm - (pair.box.radius - 0.5 * touch.overlap) * normal);
    }
    mean.s /= sum;
    mean.middle = (1 / sum) * mean.middle;
    mean.normal =
        norm(mean.normal) > 1e-9 * sum ? unit(mean.normal) : -pair.to_lab(meeting.touches().front().gap.outwards);
    const SegmentMeeting::Load& change = meeting.change();
    out.on_element.first += law.stiffness[0] * pair.to_lab(change.first);
    out.on_element.second += law.stiffness[0] * pair.to_lab(change.second);
    out.on_box.first -= law.stiffness[0] * pair.to_lab(change.first + change.second);
    out.on_box.couple += law.stiffness[0] * pair.to_lab(change.couple);
    mean.pressed = std::max(0.0, dot(out.on_box.first, mean.normal));
    mean.viscous = dot(viscous, mean.normal);
    return mean;
}

/// Adds friction at the mean place of what pushes. `memory` becomes that of this step.
void Contacts::rub_on_box(const BoxPair& pair, const BoxPressure& mean, const ContactNumbers<Pack<1>>& law, double h,
                          ContactMemory<Pack<1>>& memory, BoxContact& out) const {
    using Q = Pack<1>;
    const Vec3d &n = mean.normal, arm = mean.middle - pair.axis_at(mean.s);
    const double approach = dot(out.slip, n), before = -dot(lane(memory.viscous_part, 0), n);
    const Vec3d slip = out.slip - approach * n;
    const detail::Sliding<1> sliding{broadcast<1>(n),
                                     broadcast<1>(slip),
                                     broadcast<1>(0.5 * h * slip),
                                     Q(h),
                                     Q(0.5 * h * dot(pair.motion->spin + pair.box_motion->spin, n)),
                                     Q(mean.pressed),
                                     Q(kinds_.normal == ContactNormal::hertz ? sqrt(out.overlap) : 1.0),
                                     Q(out.weight),
                                     Q(0.0) < Q(1.0)};
    const auto friction = detail::add_friction<1>(kinds_, law, sliding, memory, nullptr, out.force);
    memory = friction.memory;
    out.force.viscous_work += 0.5 * h * approach * (before - mean.viscous);
    memory.viscous_part -= broadcast<1>(mean.viscous * n);
    const Vec3d force = lane(friction.force, 0);
    out.exert(mean.s, force, mean.middle);
    out.on_element.couple += cross(arm, force);
}

/// Memory that a contact goes on from: its own, or the spring of a neighbour if it begins near a vertex.
ContactMemory<double> Contacts::memory_before(const Exposure& bodies, std::uint32_t pair, double s,
                                              bool box_first) const {
    if (!remembers_) return {};
    const ContactMemory<double>& last = memory_[pair];
    if (status_[pair] & touching) return last;
    return {inherited_spring(bodies, pair, box_first ? 0.5 : s, box_first ? s : 0.5), last.viscous_part, last.weight};
}

/// Share in a contact of bodies: energy over that of a spring at the largest overlap here and on both neighbours.
double Contacts::weight_of(const BoxPair& pair, const SegmentMeeting& meeting) const {
    double most = meeting.deepest();
    for (const bool end : {false, true})
        if (pair.bodies.vertices[pair.element] & (end ? at_end : at_start))
            most = std::max(most, pair.meeting_of(neighbour(pair.bodies, pair.element, end), kinds_.normal).deepest());
    return meeting.energy() / SegmentMeeting::energy_of(kinds_.normal, most);
}

/// `now`: the memory of the contact, in place of the one that a step moves on.
Contacts::BoxContact Contacts::evaluate_box(const Exposure& bodies, double h, std::uint32_t number,
                                            const ContactMemory<double>* now) const {
    using Q = Pack<1>;
    const auto [a, b] = list_.pair[number];
    const PartBox *first = box_at(bodies, a), *second = box_at(bodies, b);
    if (first && second) return evaluate_boxes(bodies, h, number, now);
    BoxContact out;
    const BoxPair pair(bodies, first ? b : a, first ? a : b, first ? *first : *second);
    const SegmentMeeting meeting = pair.meeting(kinds_.normal);
    out.overlap = meeting.deepest();
    out.diameter = 2 * std::min(pair.node->radius, pair.box.radius);
    out.touches = meeting.energy() > 0;
    if (!out.touches) return out;
    const ContactNumbers<Q> law = numbers<1>(bodies, &list_.pair[number]);
    out.force.elastic_energy = out.force.friction_work = out.force.viscous_work = out.force.stiffness = 0.0;
    const BoxPressure mean = press_on_box(pair, meeting, law, h, out);
    out.s = mean.s;
    out.weight = weight_of(pair, meeting);
    out.normal = mean.normal;
    out.place = pair.centre + mean.middle;
    out.slip = pair.velocity_at(mean.s) + cross(pair.motion->spin, mean.middle - pair.axis_at(mean.s)) -
               pair.box_velocity_at(mean.middle);
    ContactMemory<Q> memory{};
    if (now) memory.spring = {broadcast<1>(now->spring.x), now->spring.stiffness};
    else set_lane(memory, 0, memory_before(bodies, number, mean.s, first != nullptr));
    rub_on_box(pair, mean, law, h, memory, out);
    out.memory = lane(memory, 0);
    return out;
}

double Contacts::normal_energy_with_box(const Exposure& bodies, std::uint32_t pair) const {
    const ContactMemory<double> nothing{};
    return evaluate_box(bodies, 0, pair, &nothing).force.elastic_energy[0];
}

Contact Contacts::contact_with_box(const Exposure& bodies, std::uint32_t pair) const {
    const BoxContact c = evaluate_box(bodies, 0, pair, &memory_[pair]);
    const bool first = box_is_first(bodies, pair);
    const ElementLoad<double>& on_first = first ? c.on_box : c.on_element;
    const double sign = first ? -1 : 1;
    return {list_.pair[pair], first ? 0 : c.s, first ? c.s : 0, on_first.first + on_first.second,
            c.overlap,        c.diameter,      c.weight,        c.place,
            sign * c.normal,  sign * c.slip};
}

/// Adds slopes of a contact whose points may be anywhere on a box and along an element: bounds of those of its points.
///   |x + t x a|^2 <= 2 |x|^2 + 2 |t|^2 R^2,  R the radius of the ball around a box;  |(1-s) x + s y|^2 <= |x|^2 +
///   |y|^2
void Contacts::stiffen_at_box(const Work& work, std::uint32_t pair, const BoxContact& contact) {
    const auto [a, b] = list_.pair[pair];
    const ContactNumbers<Pack<1>> law = numbers<1>(work.bodies, &list_.pair[pair]);
    const ContactState<Pack<1>> state{broadcast<1>(contact.normal), 0.0, contact.overlap, 0.0, {}, {}, {}, {}};
    ContactForce<Pack<1>> force = contact.force;
    force.normal = force.stiffness * contact.overlap;
    const auto slopes = contact_slopes<1>(kinds_, law, state, work.h, force, {1.0, contact.weight}, 0.0, 0.0);
    const double p = own_share_of_tangents * slopes.normal[0], q = own_share_of_tangents * slopes.tangential[0];
    const auto [x, y, z] = contact.normal;
    for (const std::uint32_t slot : {a, b}) {
        if (const PartBox* box = box_at(work.bodies, slot)) {
            const double reach = norm(box->half) + box->radius;
            stiffen(work, slot, {{x, y, z, 2 * p, 2 * q, 0, 0, 2 * std::max(p, q) * reach * reach}});
        } else {
            const double arm = work.bodies.node[slot].radius * (slot == a ? 1 : -1);
            stiffen(work, slot, {{x, y, z, p, q, 0, arm, 0}});
            stiffen(work, slot, {{x, y, z, p, q, 1, arm, 0}});
        }
    }
}

void Contacts::push_boxes(const Work& work, WorkArea& area) {
    const std::uint32_t begin = list_.first[work.block.first_slot], end = list_.first[work.block.last_slot];
    const auto first = std::lower_bound(box_pairs_.begin(), box_pairs_.end(), begin),
               last = std::lower_bound(first, box_pairs_.end(), end);
    area.box_contact.clear();
    for (auto i = first; i != last; ++i)
        area.box_contact.push_back(evaluate_box(work.bodies, work.h, *i)); // memory is as it was
    auto c = area.box_contact.begin();
    for (auto i = first; i != last; ++i, ++c) {
        const auto [a, b] = list_.pair[*i];
        if (c->intersect) area.deep.push_back(*i);
        if ((work.tangent || scene_.meeting_zone > 0) && work.bodies.owns_slot(a))
            ++work.figures.near; // no zone tells which are
        if (!c->touches) {
            if (status_[*i] & touching) end_contact(work, *i);
            continue;
        }
        memory_[*i] = c->memory;
        status_[*i] = touching;
        const bool box_first = box_is_first(work.bodies, *i);
        exert(work, a, box_first ? c->on_box : c->on_element);
        exert(work, b, box_first ? c->on_element : c->on_box);
        if (work.tangent) stiffen_at_box(work, *i, *c);
        if (!work.bodies.owns_slot(a)) continue;
        BlockFigures& figures = work.figures;
        ++figures.active;
        figures.weight += in_steps<1>(c->weight)[0];
        figures.max_overlap = std::max(figures.max_overlap, c->overlap / c->diameter);
        figures.max_stiffness = std::max(figures.max_stiffness, c->force.stiffness[0]);
        figures.elastic_energy.add(c->force.elastic_energy[0], bins_);
        figures.friction_work.add(c->force.friction_work[0], bins_);
        figures.viscous_work.add(c->force.viscous_work[0], bins_);
    }
}

} // namespace skein
