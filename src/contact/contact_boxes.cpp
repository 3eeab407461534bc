// Contacts of elements with boxes, one by one, after those of the block's capsules: which of both comes first depends
// on the scene alone. The candidate of a box is the ball around it; the law is that of capsules, and so are its points:
// an element that lies near-parallel to a face or an edge pushes at both ends of what lies beside it, and at the
// nearest point with the rest and all friction.
#include "contact/box_distance.hpp"
#include "contact/work_area.hpp"

#include <algorithm>

namespace skein {

/// The box that an exposed element is; null: it is none.
const PartBox* Contacts::box_at(const Exposure& bodies, std::uint32_t slot) const {
    const auto group = static_cast<std::size_t>(bodies.at(slot).group);
    if (group >= scene_.boxes.size() || scene_.boxes[group].empty()) return nullptr;
    const PartBox& part = scene_.boxes[group][static_cast<std::size_t>(bodies.element(slot)) / 2];
    return part.radius > 0 ? &part : nullptr;
}

/// Those among the pairs of the list.
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

/// `now`: the memory that the contact has, where it is not to move on. The element is body 1 of the law.
Contacts::BoxContact Contacts::evaluate_box(const Exposure& bodies, double h, std::uint32_t pair,
                                            const ContactMemory<double>* now) const {
    using Q = Pack<1>;
    const auto [a, b] = list_.pair[pair];
    const PartBox *first = box_at(bodies, a), *second = box_at(bodies, b);
    BoxContact out;
    if (first && second) return out; // refused by the plan
    const std::uint32_t element = first ? b : a, box_slot = first ? a : b;
    const PartBox& box = first ? *first : *second;
    const ExposedNode* node = &bodies.node[element];
    const ExposedMotion *motion = &bodies.motion[element], *of_box = &bodies.motion[box_slot];
    const Vec3d centre = bodies.node[box_slot].position;
    const Mat3d axes{of_box[1].velocity, of_box[1].spin,
                     cross(of_box[1].velocity, of_box[1].spin)}; // neighbourhood/surface.hpp
    const Vec3d p = node[0].position, d = node[1].position - p;
    const unsigned vertices = bodies.vertices[element];
    const auto nearest_between = [&](double low, double high) {
        SegmentToBox found = nearest_to_box(axes * (p + low * d - centre), axes * ((high - low) * d), box.half);
        for (double* share : {&found.s, &found.first, &found.last}) *share = low + *share * (high - low);
        return found;
    };
    const double reach = bodies.scene().vertex_reach(), seen = seen_beyond(reach);
    SegmentToBox near = nearest_between(vertices & at_start ? -seen : 0, vertices & at_end ? 1 + seen : 1);

    struct At {
        ContactState<Q> state;
        Vec3d arm; ///< of the box's point from its centre
    };
    const auto at = [&](double s) -> At {
        const BoxPoint point = nearest_on_box(axes * (p + s * d - centre), box.half);
        const Vec3d arm = transpose_times(axes, point.on_box);
        return {{broadcast<1>(-transpose_times(axes, point.outwards)), point.distance, node->radius, box.radius,
                 broadcast<1>(motion[0].velocity + s * (motion[1].velocity - motion[0].velocity)),
                 broadcast<1>(motion->spin), broadcast<1>(of_box->velocity + cross(of_box->spin, arm)),
                 broadcast<1>(of_box->spin)},
                arm};
    };
    const auto exert = [&](const ContactForce<Q>& f, double s, const Vec3d& arm) {
        const Vec3d force = lane(f.on_1, 0), moment = lane(f.moment, 0);
        out.on_element.first += (1 - s) * force;
        out.on_element.second += s * force;
        out.on_element.couple += f.arm_1[0] * moment;
        out.on_box.first -= force;
        out.on_box.couple += f.arm_2[0] * moment - cross(arm, force);
    };
    double weight = 1;
    if (const int side = vertex_side(near.s, vertices, reach); side != 0) { // the other is the nearest point of the box
        const double s = near.s;
        const BoxPoint point = nearest_on_box(axes * (p + s * d - centre), box.half);
        const Vec3d &vertex = node[side > 0].position, on_box = centre + transpose_times(axes, point.on_box);
        const auto share = vertex_share<1>(
            reach, side > 0 ? 1 - s : s, broadcast<1>(vertex), broadcast<1>(node[side <= 0].position - vertex),
            broadcast<1>(bodies.node[neighbour(bodies, element, side > 0) + (side > 0)].position - vertex),
            broadcast<1>(on_box));
        const double apart = sharing<1>(near.sine_squared, share.bend[0] * (node->radius + box.radius))[0];
        weight = 1 + apart * (share.weight[0] - 1);
        const double beyond = apart * share.beyond[0];
        near.s = std::clamp(near.s, side < 0 ? -beyond : 0.0, side > 0 ? 1 + beyond : 1.0);
    }
    const At nearest = at(near.s);
    out.s = near.s;
    out.overlap = node->radius + box.radius - nearest.state.distance[0];
    out.diameter = 2 * std::min(node->radius, box.radius);
    out.touches = out.overlap > 0;
    if (!out.touches) return out;
    const ContactState<Q>& state = nearest.state;
    out.normal = lane(state.normal, 0);
    const Vec3d arm_1 = (node->radius - 0.5 * out.overlap) * out.normal,
                arm_2 = -(box.radius - 0.5 * out.overlap) * out.normal;
    out.place = p + near.s * d + arm_1;
    out.slip =
        lane(state.velocity_1, 0) + cross(motion->spin, arm_1) - lane(state.velocity_2, 0) - cross(of_box->spin, arm_2);

    const ContactNumbers<Q> law = numbers<1>(bodies, &list_.pair[pair]);
    double share = 0, beside = 1, elsewhere = 0, elastic_energy = 0, viscous_work = 0, stiffest = 0;
    if (near.sine_squared < blend * blend && near.last > near.first) {
        share = 1 - near.sine_squared / (blend * blend);
        const SegmentToBox line = nearest_between(-1, 2); // what lies beside the face, beyond the element too
        const double first = std::clamp(line.first, 0.0, 1.0), last = std::clamp(line.last, 0.0, 1.0);
        if ((line.first < 0 && (vertices & at_start)) || (line.last > 1 && (vertices & at_end)))
            beside = std::max(0.0, last - first) / std::min(1.0, line.last - line.first);
        for (const double s : {first, last}) {
            const At end = at(s);
            ContactMemory<Q> none{};
            const Q of_end = 0.5 * share * beside;
            const auto f =
                contact_force<1>({kinds_.normal, ContactFriction::none}, law, end.state, h, none, {of_end, of_end});
            elsewhere += f.normal[0];
            elastic_energy += f.elastic_energy[0];
            viscous_work += 2 * f.viscous_work[0];
            stiffest = std::max(stiffest, f.stiffness[0]);
            exert(f, s, end.arm);
        }
    }
    ContactMemory<Q> memory{};
    if (now) memory.spring = {broadcast<1>(now->spring.x), now->spring.stiffness};
    else if (remembers_) {
        const ContactMemory<double>& last = memory_[pair];
        const FrictionSpring<double> spring =
            status_[pair] & touching ? last.spring
                                     : followed_spring(bodies, pair, first ? 0.5 : near.s, first ? near.s : 0.5);
        memory = {{broadcast<1>(spring.x), spring.stiffness}, broadcast<1>(last.viscous_part), last.weight};
    }
    const double crossing = (1 - share) * weight;
    out.weight = crossing + share * beside;
    out.touches = out.weight > 0;
    out.force = contact_force<1>(kinds_, law, nearest.state, h, memory, {crossing, out.weight}, elsewhere);
    exert(out.force, near.s, nearest.arm);
    out.memory = {
        {lane(memory.spring.x, 0), memory.spring.stiffness[0]}, lane(memory.viscous_part, 0), memory.weight[0]};
    out.force.elastic_energy += elastic_energy;
    out.force.viscous_work += viscous_work;
    out.force.stiffness = max(out.force.stiffness, Q(stiffest));
    return out;
}

double Contacts::normal_energy_with_box(const Exposure& bodies, std::uint32_t pair) const {
    const ContactMemory<double> nothing{};
    return evaluate_box(bodies, 0, pair, &nothing).force.elastic_energy[0];
}

Contact Contacts::contact_with_box(const Exposure& bodies, std::uint32_t pair) const {
    const BoxContact c = evaluate_box(bodies, 0, pair, &memory_[pair]);
    const bool first = box_at(bodies, list_.pair[pair].a) != nullptr;
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
        if (!c->touches) {
            if (status_[*i] & touching) end_contact(work, *i);
            continue;
        }
        memory_[*i] = c->memory;
        status_[*i] = touching;
        const bool box_first = box_at(work.bodies, a) != nullptr;
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
