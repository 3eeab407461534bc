// Contacts of elements with boxes, one by one, after those of the block's capsules. The order of both depends on the
// scene alone. The candidate of a box is the ball around it. The law is that of capsules. An element that lies
// near-parallel to a face or an edge pushes at both ends of what lies beside it. The nearest point has the rest of the
// force and all friction. Two boxes: contact_box_pairs.cpp.
#include "contact/box_distance.hpp"
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
                                                       cross(box_motion[1].velocity, box_motion[1].spin)},
          start(node[0].position), edge(node[1].position - start), vertices(bodies.vertices[element]) {}

    /// Point of the contact at share s of the element.
    struct Point {
        ContactState<Pack<1>> state;
        Vec3d arm; ///< from the box's centre to its point, lab, m
    };
    Point at(double s) const {
        const BoxPoint point = nearest_on_box(axes * (start + s * edge - centre), box.half);
        const Vec3d arm = transpose_times(axes, point.on_box);
        return {{broadcast<1>(-transpose_times(axes, point.outwards)), point.distance, node->radius, box.radius,
                 broadcast<1>(motion[0].velocity + s * (motion[1].velocity - motion[0].velocity)),
                 broadcast<1>(motion->spin), broadcast<1>(box_motion->velocity + cross(box_motion->spin, arm)),
                 broadcast<1>(box_motion->spin)},
                arm};
    }

    /// Nearest point among shares of the element from `low` to `high`, in shares of the whole element.
    SegmentToBox nearest_between(double low, double high) const {
        SegmentToBox found =
            nearest_to_box(axes * (start + low * edge - centre), axes * ((high - low) * edge), box.half);
        for (double* share : {&found.s, &found.first, &found.last}) *share = low + *share * (high - low);
        return found;
    }

    const Exposure& bodies;
    const std::uint32_t element;
    const PartBox& box;
    const ExposedNode* const node; ///< start and end of the element
    const ExposedMotion *const motion, *const box_motion;
    const Vec3d centre; ///< centre of the box, m
    const Mat3d axes;   ///< axes of the box, as neighbourhood/surface.hpp exposes them
    const Vec3d start, edge;
    const unsigned vertices;
};

/// Forces at the ends of the part of an element that is near-parallel to a face or an edge.
struct Contacts::BoxEnds {
    double share = 0, lambda = 1; ///< a and Lambda of theory.md (56b), (56e)
    double elsewhere = 0;         ///< normal force of both, N
    double elastic_energy = 0, viscous_work = 0, stiffness = 0;
};

void Contacts::exert_on_both(const ContactForce<Pack<1>>& f, double s, const Vec3d& arm, BoxContact& out) {
    const Vec3d force = lane(f.on_1, 0), moment = lane(f.moment, 0);
    out.on_element.first += (1 - s) * force;
    out.on_element.second += s * force;
    out.on_element.couple += f.arm_1[0] * moment;
    out.on_box.first -= force;
    out.on_box.couple += f.arm_2[0] * moment - cross(arm, force);
}

/// Weight of a contact near a vertex, theory.md (59e). Takes the nearest point back to where the contact is.
double Contacts::weight_at_vertex(const BoxPair& pair, SegmentToBox& near) const {
    const double reach = pair.bodies.scene().vertex_reach(), s = near.s;
    const int side = vertex_side(s, pair.vertices, reach);
    if (side == 0) return 1;
    const BoxPoint point = nearest_on_box(pair.axes * (pair.start + s * pair.edge - pair.centre), pair.box.half);
    const Vec3d &vertex = pair.node[side > 0].position, on_box = pair.centre + transpose_times(pair.axes, point.on_box);
    const std::uint32_t next = neighbour(pair.bodies, pair.element, side > 0) + (side > 0);
    const auto share = vertex_share<1>(reach, side > 0 ? 1 - s : s, broadcast<1>(vertex),
                                       broadcast<1>(pair.node[side <= 0].position - vertex),
                                       broadcast<1>(pair.bodies.node[next].position - vertex), broadcast<1>(on_box));
    const double apart = sharing<1>(near.sine_squared, share.bend[0] * (pair.node->radius + pair.box.radius))[0],
                 beyond = apart * share.beyond[0];
    near.s = std::clamp(s, side < 0 ? -beyond : 0.0, side > 0 ? 1 + beyond : 1.0);
    return 1 + apart * (share.weight[0] - 1);
}

/// Adds the forces at both ends of what lies beside a face or an edge.
Contacts::BoxEnds Contacts::push_box_ends(const BoxPair& pair, const SegmentToBox& near, double h,
                                          const ContactNumbers<Pack<1>>& law, BoxContact& out) const {
    BoxEnds ends;
    if (!(near.sine_squared < blend * blend && near.last > near.first)) return ends;
    ends.share = 1 - near.sine_squared / (blend * blend);
    const SegmentToBox line = pair.nearest_between(-1, 2); // the part beside the face may go on beyond the element
    const double first = std::clamp(line.first, 0.0, 1.0), last = std::clamp(line.last, 0.0, 1.0);
    if ((line.first < 0 && (pair.vertices & at_start)) || (line.last > 1 && (pair.vertices & at_end)))
        ends.lambda = std::max(0.0, last - first) / std::min(1.0, line.last - line.first);
    for (const double s : {first, last}) {
        const BoxPair::Point end = pair.at(s);
        ContactMemory<Pack<1>> none{};
        const Pack<1> weight = 0.5 * ends.share * ends.lambda;
        const auto f =
            contact_force<1>({kinds_.normal, ContactFriction::none}, law, end.state, h, none, {weight, weight});
        ends.elsewhere += f.normal[0];
        ends.elastic_energy += f.elastic_energy[0];
        ends.viscous_work += 2 * f.viscous_work[0];
        ends.stiffness = std::max(ends.stiffness, f.stiffness[0]);
        exert_on_both(f, s, end.arm, out);
    }
    return ends;
}

/// Memory that a contact goes on from: its own, or the spring of a neighbour if it begins near a vertex.
ContactMemory<double> Contacts::memory_before(const Exposure& bodies, std::uint32_t pair, double s,
                                              bool box_first) const {
    if (!remembers_) return {};
    const ContactMemory<double>& last = memory_[pair];
    if (status_[pair] & touching) return last;
    return {inherited_spring(bodies, pair, box_first ? 0.5 : s, box_first ? s : 0.5), last.viscous_part, last.weight};
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
    const double seen = seen_beyond(bodies.scene().vertex_reach());
    SegmentToBox near =
        pair.nearest_between(pair.vertices & at_start ? -seen : 0, pair.vertices & at_end ? 1 + seen : 1);
    const double weight = weight_at_vertex(pair, near);
    const BoxPair::Point nearest = pair.at(near.s);
    const ContactState<Q>& state = nearest.state;
    out.s = near.s;
    out.overlap = pair.node->radius + pair.box.radius - state.distance[0];
    out.diameter = 2 * std::min(pair.node->radius, pair.box.radius);
    out.touches = out.overlap > 0;
    if (!out.touches) return out;
    out.normal = lane(state.normal, 0);
    const Vec3d arm_1 = (pair.node->radius - 0.5 * out.overlap) * out.normal,
                arm_2 = -(pair.box.radius - 0.5 * out.overlap) * out.normal;
    out.place = pair.start + near.s * pair.edge + arm_1;
    out.slip = lane(state.velocity_1, 0) + cross(pair.motion->spin, arm_1) - lane(state.velocity_2, 0) -
               cross(pair.box_motion->spin, arm_2);

    const ContactNumbers<Q> law = numbers<1>(bodies, &list_.pair[number]);
    const BoxEnds ends = push_box_ends(pair, near, h, law, out);
    ContactMemory<Q> memory{};
    if (now) memory.spring = {broadcast<1>(now->spring.x), now->spring.stiffness};
    else set_lane(memory, 0, memory_before(bodies, number, near.s, first != nullptr));
    const double normal_weight = (1 - ends.share) * weight;
    out.weight = normal_weight + ends.share * ends.lambda;
    out.touches = out.weight > 0;
    out.force = contact_force<1>(kinds_, law, state, h, memory, {normal_weight, out.weight}, ends.elsewhere);
    exert_on_both(out.force, near.s, nearest.arm, out);
    out.memory = lane(memory, 0);
    out.force.elastic_energy += ends.elastic_energy;
    out.force.viscous_work += ends.viscous_work;
    out.force.stiffness = max(out.force.stiffness, Q(ends.stiffness));
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
        if (!c->touches) {
            if (status_[*i] & touching) end_contact(work, *i);
            continue;
        }
        memory_[*i] = c->memory;
        status_[*i] = touching;
        const bool box_first = box_is_first(work.bodies, *i);
        exert(work, a, box_first ? c->on_box : c->on_element);
        exert(work, b, box_first ? c->on_element : c->on_box);
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
