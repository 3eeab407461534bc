#include "immersion/force_balance.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace skein {

namespace {

/// Drag of a marker's fluid about d1, d2 and d3, kg m^2.
Vec3d turn_drag(const RodMarker& marker, const Vec3d& mass) {
    const double squared_d1 = marker.off_d1 * marker.off_d1, squared_d2 = marker.off_d2 * marker.off_d2,
                 squared_d3 = marker.off_d3 * marker.off_d3;
    return ((mass.x + mass.y + mass.z) / 3) *
           Vec3d{squared_d2 + squared_d3, squared_d1 + squared_d3, squared_d1 + squared_d2};
}

/// True for rods that do not move along themselves as a whole: an end is held in all directions. theory.md (156)
bool has_held_end(const RodSpec& rods) {
    return (rods.start != EndKind::free && rods.start_free.empty()) ||
           (rods.end != EndKind::free && rods.end_free.empty());
}

} // namespace

ForceBalance::ForceBalance(std::span<const RodGroup> groups, const ImmersedRods& rods,
                           std::shared_ptr<FluidLoads> loads, const Fluid& fluid, Weight weight,
                           std::vector<SharedNode> shared)
    : groups_(groups), rods_(rods), loads_(std::move(loads)), fluid_(fluid), weight_(std::move(weight)),
      shared_(std::move(shared)), exchange_(loads_->load.size()), step_(exchange_.size()), place_(rods.count()),
      off_(rods.count()) {
    std::int64_t first = 0;
    for (const RodGroup& group : groups_) {
        first_slot_.push_back(first);
        first += group.count() * group.slots();
        if (group.body()) body_step_.resize(step_.size());
    }
    if (rods_.has_sharp_rods()) {
        sharp_stage_.resize(step_.size());
        sharp_slot_.resize(step_.size());
    }
    slots_of_scene_ = to_index(first);
    start_inner_fluid();
}

void ForceBalance::start_inner_fluid() {
    rods_.read(0, [&](int, std::size_t i, const RodCopy& rod) {
        const RodGroup& group = group_of(i);
        const InertiaInFluid& inertia = inertia_of(i);
        if (group.body()) {
            const BodyMomentum within = inner_momentum(i, rod);
            exchange_[loads_->first(i)].residual_impulse = within.linear;
            exchange_[loads_->first(i)].residual_angular_impulse = within.angular;
            return;
        }
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            SlotExchange& slot = exchange_[loads_->first(i) + k];
            slot.residual_impulse =
                (inertia.of_nodes[k].displaced * group.node_mass[k]) * lane(rod.state[k].velocity, 0);
            if (k == group.element.size()) break;
            slot.residual_angular_impulse =
                transpose_times(rod.frames[k], scale(inertia.of_elements[k].displaced,
                                                     scale(group.element[k].inertia, lane(rod.state[k].spin, 0))));
        }
        for (std::size_t k = 0; rods_.is_sharp_rod(i) && k < rod.state.size(); ++k) {
            SharpSlot& slot = sharp_slot_[loads_->first(i) + k];
            slot.mean_velocity = lane(rod.state[k].velocity, 0);
            if (k < rod.frames.size()) slot.mean_spin = transpose_times(rod.frames[k], lane(rod.state[k].spin, 0));
        }
    });
}

void ForceBalance::begin_step_of_sharp(std::size_t i, const RodCopy& body, const RigidMotion& slip) {
    const RodGroup& group = group_of(i);
    const InertiaInFluid& inertia = inertia_of(i);
    SlotExchange& slot = exchange_[loads_->first(i)];
    SlotStep& step = step_[loads_->first(i)];
    const Mat3d& frame = body.frames[0];
    const Vec3d pull = (inertia.of_nodes[0].added * group.node_mass[0]) * slip.velocity,
                turn = transpose_times(
                    frame, scale(scale(inertia.of_elements[0].added, group.element[0].inertia), frame * slip.spin));
    step.impulse = slot.residual_impulse + slot.added_momentum + pull;
    step.angular_impulse = slot.residual_angular_impulse + slot.added_angular_momentum + turn;
    slot.residual_impulse = -pull;
    slot.residual_angular_impulse = -turn;
}

void ForceBalance::begin_step(double lag, const std::function<RigidMotion(std::size_t i)>& slip) {
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        const bool held = has_held_end(group_of(i).spec());
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            SlotStep& slot = step_[loads_->first(i) + k];
            slot.velocity = lane(rod.state[k].velocity, 0);
            slot.spin = lane(rod.state[k].spin, 0);
            if (held) slot.along = rod.frames[std::min(k, rod.frames.size() - 1)].d3;
        }
        if (!group_of(i).body()) return;
        BodyStep& body = body_step_[loads_->first(i)];
        body.momentum = body_momentum(i, rod);
        body.frame = rod.frames[0];
        if (inertia_of(i).sharp) begin_step_of_sharp(i, rod, slip(i));
    });
}

void ForceBalance::begin_stage(const Stage& stage, double lag, const Responses& responses,
                               const SharpResponses& of_sharp) {
    pace_ = std::min(1.0, stage.step / fluid_.reference_step);
    length_ = stage.step;
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        const auto load = std::span(loads_->load).subspan(loads_->first(i), rod.state.size());
        const auto received = std::span(loads_->received).subspan(loads_->first(i), rod.state.size());
        std::fill(load.begin(), load.end(), FluidLoad{});
        std::fill(received.begin(), received.end(), FluidImpulse{});
        add_responses(i, rod, responses, load);
        if (rods_.is_sharp_rod(i)) add_sharp_responses(i, rod, of_sharp(i), load);
        if (group_of(i).body()) {
            BodyStep& body = body_step_[loads_->first(i)];
            body.stage_frame = rod.frames[0];
            body.stage_velocity = lane(rod.state[0].velocity, 0);
            body.stage_spin = lane(rod.state[0].spin, 0);
            add_cross_drags(i, rod, responses, load.front());
        }
        if (group_of(i).closed()) { // its last node is its first
            load.front().push += load.back().push;
            load.front().drag += load.back().drag;
            load.back() = {};
        }
        add_impulses(i, rod, stage, load);
    });
    share(loads_->load, &FluidLoad::push);
    share(loads_->load, &FluidLoad::drag);
    give_loads_to_bodies();
}

void ForceBalance::forget_received() { std::fill(loads_->received.begin(), loads_->received.end(), FluidImpulse{}); }

template <class Slots, class Member> void ForceBalance::share(Slots& of_slots, Member member) const {
    for (const SharedNode& node : shared_) {
        if (!node.arms.empty() || (node.is_torn && node.is_torn(rods_.rods()))) continue;
        Vec3d sum{0, 0, 0};
        for (const std::size_t slot : node.slots) sum += of_slots[slot].*member;
        for (std::size_t i = 0; i < node.slots.size(); ++i) of_slots[node.slots[i]].*member = node.shares[i] * sum;
    }
}

void ForceBalance::add_responses(std::size_t i, const RodCopy& rod, const Responses& responses,
                                 std::span<FluidLoad> load) {
    rods_.for_markers(i, [&](std::size_t m, const RodMarker& marker) {
        place_[m] = ImmersedRods::place_of(marker, rod);
        off_[m] = ImmersedRods::off_axis(marker, rod.frames[marker.element]);
        const MarkerResponse response = responses(m);
        const Vec3d mass = fluid_.density * response.volume, impulse = fluid_.density * response.impulse;
        FluidLoad &start = load[marker.element], &end = load[ImmersedRods::second_slot(marker, load.size())];
        start.push += (1 - marker.along) * impulse;
        start.drag += (1 - marker.along) * mass;
        end.push += marker.along * impulse;
        end.drag += marker.along * mass;
        start.couple += cross(off_[m], impulse);
        start.turn_drag += turn_drag(marker, mass);
    });
}

void ForceBalance::add_sharp_responses(std::size_t i, const RodCopy& rod,
                                       std::span<const SharpForcing::Response> responses, std::span<FluidLoad> load) {
    begin_sharp_stage(i, rod, responses);
    for (std::size_t k = 0; k < load.size(); ++k) load[k].push -= sharp_slot_[loads_->first(i) + k].relative;
    for (std::size_t k = 0; k < responses.size(); ++k) {
        const SharpForcing::Response& response = responses[k];
        for (std::size_t end = 0; end < 2; ++end) {
            const Vec3d drag = fluid_.density * response.drag[end], velocity = lane(rod.state[k + end].velocity, 0);
            load[k + end].drag += drag;
            load[k + end].push +=
                scale(drag, velocity) - fluid_.density * (response.given[end] - response.relative[end]);
        }
        const Vec3d turn_drag = fluid_.density * response.turn_drag;
        load[k].turn_drag += turn_drag;
        load[k].couple += transpose_times(rod.frames[k], scale(turn_drag, lane(rod.state[k].spin, 0))) -
                          fluid_.density * response.turn_given;
    }
}

void ForceBalance::begin_sharp_stage(std::size_t i, const RodCopy& rod,
                                     std::span<const SharpForcing::Response> responses) {
    const std::size_t n = responses.size();
    for (std::size_t k = 0; k <= n; ++k) {
        SharpStage& slot = sharp_stage_[loads_->first(i) + k] = {};
        slot.place = lane(rod.state[k].position, 0);
        slot.velocity = lane(rod.state[k].velocity, 0);
        if (k == n) break;
        slot.frame = rod.frames[k];
        slot.spin = transpose_times(slot.frame, lane(rod.state[k].spin, 0));
        slot.shared = fluid_.density * responses[k].shared;
        for (std::size_t end = 0; end < 2; ++end)
            slot.turn_shared[end] = fluid_.density * responses[k].turn_shared[end];
    }
}

Vec3d ForceBalance::mean_added_velocity(std::size_t i) const {
    if (!rods_.is_sharp_rod(i)) return {0, 0, 0};
    const RodGroup& group = group_of(i);
    Vec3d momentum{0, 0, 0};
    double mass = 0;
    for (std::size_t k = 0; k < group.node_mass.size(); ++k) {
        momentum += exchange_[loads_->first(i) + k].added_momentum;
        mass += inertia_of(i).of_nodes[k].added * group.node_mass[k];
    }
    return mass > 0 ? (1 / mass) * momentum : Vec3d{0, 0, 0};
}

Vec3d ForceBalance::returned(std::size_t i, std::size_t k, const Vec3d& mean) const {
    const InertiaShares<double>& of_node = inertia_of(i).of_nodes[k];
    const double fraction = theta(of_node.relaxation);
    const Vec3d& along = step_[loads_->first(i) + k].along;
    return fraction * exchange_[loads_->first(i) + k].added_momentum +
           ((1 - fraction) * of_node.added * group_of(i).node_mass[k]) *
               (mean - dot(mean, along) * along); // theory.md (156)
}

ForceBalance::BodyMomentum ForceBalance::inner_momentum(std::size_t i, const RodCopy& body) const {
    const InnerFluid& inner = inertia_of(i).inner;
    const Mat3d& frame = body.frames[0];
    const Vec3d spin = lane(body.state[0].spin, 0), velocity = frame * lane(body.state[0].velocity, 0);
    return {inner.mass * transpose_times(frame, velocity + cross(spin, inner.centre)),
            transpose_times(frame, inner.inertia * spin + inner.mass * cross(inner.centre, velocity))};
}

ForceBalance::BodyMomentum ForceBalance::body_momentum(std::size_t i, const RodCopy& body) const {
    const RodGroup& group = group_of(i);
    const BodyMomentum within = inner_momentum(i, body);
    return {group.node_mass[0] * lane(body.state[0].velocity, 0) - within.linear,
            transpose_times(body.frames[0], scale(group.element[0].inertia, lane(body.state[0].spin, 0))) -
                within.angular};
}

void ForceBalance::add_cross_drags(std::size_t i, const RodCopy& body, const Responses& responses,
                                   FluidLoad& load) const {
    const Mat3d& frame = body.frames[0];
    const Vec3d velocity = lane(body.state[0].velocity, 0), spin = lane(body.state[0].spin, 0),
                turning = transpose_times(frame, spin);
    Vec3d turned{0, 0, 0}; // couple by spin, of which drags have the diagonal
    rods_.for_markers(i, [&](std::size_t m, const RodMarker&) {
        const Vec3d mass = fluid_.density * responses(m).volume, by_turning = scale(mass, cross(turning, off_[m]));
        load.push -= by_turning;
        load.couple -= cross(off_[m], scale(mass, velocity));
        turned += cross(off_[m], by_turning);
    });
    load.couple += transpose_times(frame, scale(load.turn_drag, spin)) - turned;
}

void ForceBalance::add_impulses(std::size_t i, const RodCopy& rod, const Stage& stage, std::span<FluidLoad> load) {
    const RodGroup& group = group_of(i);
    const InertiaInFluid& inertia = inertia_of(i);
    const double per_length = 1 / stage.length, share = stage.length / stage.step;
    const Vec3d mean = mean_added_velocity(i);
    const Vec3d buoyancy = (-inertia.density_ratio) * weight_(to_index(own(i).group), stage.begin + 0.5 * stage.length);
    for (std::size_t k = 0; k < load.size(); ++k) {
        const SlotExchange& slot = exchange_[loads_->first(i) + k];
        SlotStep& step = step_[loads_->first(i) + k];
        step.own_impulse = (group.node_mass[k] * stage.length) * buoyancy;
        if (inertia.sharp) {
            step.own_impulse += share * step.impulse;
            step.own_angular_impulse =
                share * step.angular_impulse + cross(transpose_times(rod.frames[0], inertia.buoyancy_centre),
                                                     (group.node_mass[k] * stage.length) * buoyancy);
            load[k].push = per_length * step.own_impulse;
            load[k].couple = per_length * step.own_angular_impulse;
            break;
        }
        step.own_impulse += rods_.is_sharp_rod(i)
                                ? share * returned(i, k, mean)
                                : (share * theta(inertia.of_nodes[k].relaxation)) * slot.added_momentum;
        load[k].push = per_length * (load[k].push + slot.residual_impulse + step.own_impulse);
        load[k].drag = per_length * load[k].drag;
        if (k == group.element.size()) break;
        step.own_angular_impulse =
            share * transpose_times(rod.frames[k], scale(theta(inertia.of_elements[k].relaxation),
                                                         rod.frames[k] * slot.added_angular_momentum));
        if (group.body())
            step.own_angular_impulse += cross(transpose_times(rod.frames[0], inertia.buoyancy_centre),
                                              (group.node_mass[k] * stage.length) * buoyancy);
        load[k].couple = per_length * (load[k].couple + slot.residual_angular_impulse + step.own_angular_impulse);
        load[k].turn_drag = per_length * load[k].turn_drag;
    }
}

void ForceBalance::find_mean_velocities(double length, double lag, std::span<Vec3d> velocities) {
    const double per_length = 1 / length;
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        rods_.for_markers(i, [&](std::size_t m, const RodMarker& marker) {
            velocities[m] = per_length * (ImmersedRods::place_of(marker, rod) - place_[m]);
        });
        for (std::size_t k = 0; rods_.is_sharp_rod(i) && k < rod.state.size(); ++k) {
            SharpStage& stage = sharp_stage_[loads_->first(i) + k];
            SharpSlot& slot = sharp_slot_[loads_->first(i) + k];
            slot.mean_velocity = per_length * (lane(rod.state[k].position, 0) - stage.place);
            stage.gain = slot.mean_velocity - stage.velocity;
            if (k == rod.frames.size()) break;
            slot.mean_spin = mean_spin(stage.frame, rod.frames[k], length);
            stage.turn_gain = slot.mean_spin - stage.spin;
        }
    });
}

void ForceBalance::take_given(std::size_t i, std::span<const SharpForcing::GivenByElement> given) {
    const std::size_t first = loads_->first(i), n = given.size();
    std::vector<Vec3d> relative(n + 1);
    for (std::size_t k = 0; k < n; ++k) {
        SlotExchange &start = exchange_[first + k], &end = exchange_[first + k + 1];
        const auto& [whole, at_end, relative_of] = given[k];
        const SharpStage& here = sharp_stage_[first + k];
        // Loads have the fluid's inertia at nodes, and the fluid has it between them. theory.md (155)
        const Vec3d kept = scale(here.shared, here.gain - sharp_stage_[first + k + 1].gain);
        start.residual_impulse -= fluid_.density * (whole.linear - at_end) + kept;
        end.residual_impulse -= fluid_.density * at_end - kept;
        start.residual_angular_impulse -= fluid_.density * whole.angular;
        for (std::size_t end_of = 0; end_of < 2; ++end_of) relative[k + end_of] += fluid_.density * relative_of[end_of];
        const std::size_t other = (k + 1) % n;
        const SharpStage& next = sharp_stage_[first + other];
        const Vec3d faster = here.turn_gain - next.turn_gain,
                    turn_kept = transpose_times(here.frame, scale(here.turn_shared[1], here.frame * faster)) +
                                transpose_times(next.frame, scale(next.turn_shared[0], next.frame * faster));
        start.residual_angular_impulse -= turn_kept;
        exchange_[first + other].residual_angular_impulse += turn_kept;
    }
    for (std::size_t k = 0; k <= n; ++k) { // Motion relative to the axis is within the surface. theory.md (155b)
        Vec3d& before = sharp_slot_[first + k].relative;
        exchange_[first + k].residual_impulse += relative[k] - before;
        before = relative[k];
    }
}

void ForceBalance::end_stage(std::span<const Vec3d> changes, const std::function<GivenBySurface(std::size_t i)>& given,
                             const GivenByElements& given_by_rod) {
    for (std::size_t i = 0; i < rods_.rods().local().size(); ++i) {
        const RodGroup& group = group_of(i);
        const std::size_t first = loads_->first(i);
        const auto slots = std::span(exchange_).subspan(first, to_index(group.slots()));
        for (std::size_t k = 0; k < slots.size(); ++k) {
            const FluidImpulse& received = loads_->received[first + k];
            slots[k].residual_impulse += step_[first + k].own_impulse - received.on_node;
            if (k < group.element.size())
                slots[k].residual_angular_impulse += step_[first + k].own_angular_impulse - received.on_element;
        }
        rods_.for_markers(i, [&](std::size_t m, const RodMarker& marker) {
            const Vec3d given = (fluid_.density * fluid_.cell_volume) * changes[m];
            slots[marker.element].residual_impulse -= (1 - marker.along) * given;
            slots[ImmersedRods::second_slot(marker, slots.size())].residual_impulse -= marker.along * given;
            slots[marker.element].residual_angular_impulse -= cross(off_[m], given);
        });
        if (rods_.is_sharp_rod(i)) take_given(i, given_by_rod(i));
        if (inertia_of(i).sharp) {
            const GivenBySurface by = given(i);
            slots.front().residual_impulse -= by.linear;
            slots.front().residual_angular_impulse -= by.angular;
        }
        if (group.closed()) {
            slots.front().residual_impulse += slots.back().residual_impulse;
            slots.back().residual_impulse = {0, 0, 0};
        }
    }
    share(exchange_, &SlotExchange::residual_impulse);
    give_residuals_to_bodies();
}

void ForceBalance::give_loads_to_bodies() {
    for (const SharedNode& node : shared_) {
        if (node.arms.empty()) continue;
        const BodyStep& body = body_step_[node.slots.front()];
        const Vec3d turning = transpose_times(body.stage_frame, body.stage_spin);
        FluidLoad& whole = loads_->load[node.slots.front()];
        for (std::size_t i = 1; i < node.slots.size(); ++i) {
            FluidLoad& own = loads_->load[node.slots[i]];
            const Vec3d &arm = node.arms[i], off = transpose_times(body.stage_frame, arm),
                        by_turning = scale(own.drag, cross(turning, off)),
                        turn = turn_drag({.element = 0, .along = 0, .off_d1 = arm.x, .off_d2 = arm.y, .off_d3 = arm.z},
                                         own.drag);
            whole.push += own.push - by_turning;
            whole.drag += own.drag;
            whole.couple += cross(off, own.push - scale(own.drag, body.stage_velocity) - by_turning) +
                            transpose_times(body.stage_frame, scale(turn, body.stage_spin));
            whole.turn_drag += turn;
            own.push = own.drag = {0, 0, 0};
        }
    }
}

void ForceBalance::give_residuals_to_bodies() {
    for (const SharedNode& node : shared_) {
        if (node.arms.empty()) continue;
        SlotExchange& whole = exchange_[node.slots.front()];
        for (std::size_t i = 1; i < node.slots.size(); ++i) {
            SlotExchange& own = exchange_[node.slots[i]];
            whole.residual_impulse += own.residual_impulse;
            whole.residual_angular_impulse +=
                cross(transpose_times(body_step_[node.slots.front()].stage_frame, node.arms[i]), own.residual_impulse);
            own.residual_impulse = {0, 0, 0};
        }
    }
}

void ForceBalance::end_step(double lag) {
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        const RodGroup& group = group_of(i);
        const InertiaInFluid& inertia = inertia_of(i);
        if (group.body()) return end_step_of_body(i, rod);
        const Vec3d mean = mean_added_velocity(i);
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            SlotExchange& slot = exchange_[loads_->first(i) + k];
            const SlotStep& before = step_[loads_->first(i) + k];
            const InertiaShares<double>& of_node = inertia.of_nodes[k];
            const Vec3d kept = rods_.is_sharp_rod(i) ? slot.added_momentum - returned(i, k, mean)
                                                     : (1 - theta(of_node.relaxation)) * slot.added_momentum;
            slot.added_momentum =
                kept + (of_node.added * group.node_mass[k]) * (lane(rod.state[k].velocity, 0) - before.velocity);
            if (k == group.element.size()) break;
            const InertiaShares<Vec3d>& of_element = inertia.of_elements[k];
            const Vec3d old = rod.frames[k] * slot.added_angular_momentum,
                        gain = lane(rod.state[k].spin, 0) - before.spin;
            slot.added_angular_momentum =
                transpose_times(rod.frames[k], old - scale(theta(of_element.relaxation), old) +
                                                   scale(of_element.added, scale(group.element[k].inertia, gain)));
        }
    });
}

void ForceBalance::end_step_of_body(std::size_t i, const RodCopy& body) {
    const RodGroup& group = group_of(i);
    const InertiaInFluid& inertia = inertia_of(i);
    const std::size_t own_slot = loads_->first(i);
    SlotExchange& slot = exchange_[own_slot];
    const SlotStep& before = step_[own_slot];
    const BodyStep& begin = body_step_[own_slot];
    const BodyMomentum end = body_momentum(i, body);
    const Vec3d &own = group.element[0].inertia, spin = lane(body.state[0].spin, 0),
                velocity = lane(body.state[0].velocity, 0);
    const auto mean = [](const Vec3d& a, const Vec3d& b) { return 0.5 * (a + b); };
    // Impulses of kicks: what the rates gain besides the motion of a free top.
    const double mass = inertia.of_nodes[0].effective * group.node_mass[0];
    const Vec3d middle = mean(before.spin, spin),
                of_top = scale(group.element[0].inv_inertia, cross(scale(own, middle), middle)),
                kicked = scale(scale(inertia.of_elements[0].effective, own), spin - before.spin - length_ * of_top),
                angular_impulse = mean(transpose_times(begin.frame, kicked), transpose_times(body.frames[0], kicked)),
                carried = cross(mean(before.velocity, velocity), mean(begin.momentum.linear, end.linear));
    slot.added_momentum = (1 - theta(inertia.of_nodes[0].relaxation)) * slot.added_momentum +
                          (mass * (velocity - before.velocity) - (end.linear - begin.momentum.linear));
    const Vec3d old = body.frames[0] * slot.added_angular_momentum;
    slot.added_angular_momentum =
        transpose_times(body.frames[0], old - scale(theta(inertia.of_elements[0].relaxation), old)) +
        (angular_impulse - (end.angular - begin.momentum.angular) - length_ * carried);
}

std::vector<Vec3d> ForceBalance::momentum(double lag) const {
    std::vector<Vec3d> all(exchange_.size());
    rods_.read(lag, [&](int, std::size_t i, const RodCopy& rod) {
        if (group_of(i).body()) {
            const SlotExchange& slot = exchange_[loads_->first(i)];
            all[loads_->first(i)] = body_momentum(i, rod).linear + slot.added_momentum + slot.residual_impulse;
            return;
        }
        for (std::size_t k = 0; k < rod.state.size(); ++k) {
            const SlotExchange& slot = exchange_[loads_->first(i) + k];
            if (!sharp_slot_.empty()) all[loads_->first(i) + k] -= sharp_slot_[loads_->first(i) + k].relative;
            all[loads_->first(i) + k] += (group_of(i).node_mass[k] * (1 - inertia_of(i).of_nodes[k].displaced)) *
                                             lane(rod.state[k].velocity, 0) +
                                         slot.added_momentum + slot.residual_impulse;
        }
    });
    return all;
}

template <class Body> void ForceBalance::for_slots(Body&& body) const {
    for (std::size_t i = 0; i < rods_.rods().local().size(); ++i) {
        const std::int64_t slots = group_of(i).slots(), first = nth(first_slot_, own(i).group) + own(i).index * slots;
        for (std::int64_t k = 0; k < slots; ++k) body(first + k, loads_->first(i) + to_index(k));
    }
}

std::size_t ForceBalance::record() const {
    return (sizeof(SlotExchange) + (rods_.has_sharp_rods() ? sizeof(SharpSlot) : 0)) / sizeof(double);
}

ForceBalance::SlotRecord ForceBalance::record_of(std::size_t slot) const {
    struct Both {
        SlotExchange exchange;
        SharpSlot sharp;
    };
    return std::bit_cast<SlotRecord>(Both{exchange_[slot], sharp_slot_.empty() ? SharpSlot{} : sharp_slot_[slot]});
}

std::vector<double> ForceBalance::saved(const Communicator& comm) const {
    std::vector<double> mine;
    for_slots([&](std::int64_t in_scene, std::size_t slot) {
        mine.push_back(static_cast<double>(in_scene));
        const SlotRecord numbers = record_of(slot);
        mine.insert(mine.end(), numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(record()));
    });
    const std::vector<double> all = comm.all_gather(mine);
    std::vector<double> sorted(saved_numbers());
    for (std::size_t at = 0; at < all.size(); at += record() + 1)
        std::copy_n(&all[at + 1], record(), &sorted[record() * static_cast<std::size_t>(all[at])]);
    return sorted;
}

void ForceBalance::restore(std::span<const double> saved) {
    for_slots([&](std::int64_t in_scene, std::size_t slot) {
        const auto numbers = saved.subspan(to_index(in_scene) * record(), record());
        const auto take = [&](auto& to, std::size_t from) {
            std::array<double, sizeof(to) / sizeof(double)> part;
            std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(from), part.size(), part.begin());
            to = std::bit_cast<std::remove_reference_t<decltype(to)>>(part);
        };
        take(exchange_[slot], 0);
        if (!sharp_slot_.empty()) take(sharp_slot_[slot], sizeof(SlotExchange) / sizeof(double));
    });
}

std::uint64_t ForceBalance::digest() const {
    std::uint64_t sum = 0;
    for_slots([&](std::int64_t in_scene, std::size_t slot) {
        sum += hash_numbers(in_scene, std::span<const double>(record_of(slot)).first(record()));
    });
    return sum;
}

} // namespace skein
