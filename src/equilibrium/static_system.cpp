#include "equilibrium/static_system.hpp"

#include "core/rotation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// True where an end holds the rod against all motions as a rigid body, and it is not round: a round one may turn with
/// its bending about the axis of the grip.
bool is_gripped(const RodGroup& group) {
    const auto grips = [&](EndKind kind, int node) {
        return (kind == EndKind::clamped || kind == EndKind::clamped_frozen) && group.holds_node(node);
    };
    if (std::all_of(group.element.begin(), group.element.end(),
                    [](const ElementConstants& e) { return e.bending.x == e.bending.y; }))
        return false;
    return group.strained() && (grips(group.spec().start, 0) || grips(group.spec().end, group.elements()));
}

/// True where a rod is the same after any turn about its own axis: straight at rest, and round, in bending and inertia.
bool is_round(const RodGroup& group) {
    const auto along = [](const Vec3d& v) { return v.x == 0 && v.y == 0; };
    const auto alike = [](const Vec3d& v) { return v.x == v.y; };
    return group.strained() && group.spec().magnetisation.pattern == MagnetisationPattern::none &&
           std::all_of(group.element.begin(), group.element.end(),
                       [&](const ElementConstants& e) {
                           return alike(e.bending) && alike(e.inertia) && alike(e.stiffness) && along(e.rest_strain);
                       }) &&
           std::all_of(group.voronoi.begin(), group.voronoi.end(), [&](const VoronoiConstants& cell) {
               return alike(cell.stiffness) && along(cell.rest_curvature);
           });
}

bool is_zero(const StiffnessBlock& block) {
    return std::all_of(block.begin(), block.end(),
                       [](const auto& r) { return std::all_of(r.begin(), r.end(), [](double x) { return x == 0; }); });
}

} // namespace

StaticSystem::StaticSystem(std::span<const RodGroup> groups, std::span<const LocalRod> rods,
                           std::unique_ptr<StaticRods> at_rest, std::unique_ptr<StaticContacts> contacts,
                           const Communicator* ranks)
    : groups_(groups), rods_(rods.begin(), rods.end()), at_rest_(std::move(at_rest)),
      unknowns_(groups, rods_, *at_rest_), contacts_(std::move(contacts)), ranks_(ranks) {
    choose_sample();
    all_gripped_ = std::all_of(rods_.begin(), rods_.end(),
                               [&](const LocalRod& rod) { return is_gripped(nth(groups_, rod.group)); });
    double bending = 0;
    slow_eigenvalue_ = HUGE_VAL;
    for (const LocalRod& rod : rods_) {
        const RodGroup& group = nth(groups_, rod.group);
        double length = 0, mass = 0, soft = HUGE_VAL;
        for (const double m : group.node_mass) mass += m;
        for (const ElementConstants& e : group.element) {
            length += e.rest_length;
            element_ = std::max(element_, e.rest_length);
            bending = std::max({bending, e.bending.x, e.bending.y});
            if (contacts_ && e.radius > 0) first_way_ = std::min(first_way_, 0.5 * e.radius);
            soft = std::min({soft, e.bending.x, e.bending.y});
        }
        length_ = std::max(length_, length);
        if (group.strained() && mass > 0)
            slow_eigenvalue_ = std::min(slow_eigenvalue_, 0.1 * soft / (mass * length * length * length));
    }
    if (slow_eigenvalue_ == HUGE_VAL) slow_eigenvalue_ = 1;
    constexpr double unseen = 1e-9; // strain of joints between bodies, far above rounding of their places
    const JointStiffness joint = at_rest_->stiffest_joint();
    least_force_ = bending > 0 ? 1e-3 * bending / (length_ * length_)
                               : unseen * std::max(joint.along * length_, joint.about / length_);
    // Nodes of several rods at once have columns of several rods.
    if (ranks_ && ranks_->size() > 1 && at_rest_->common_nodes().empty()) share_rods(*ranks_);
}

bool StaticSystem::is_heap() const {
    constexpr int least_rods = 1000, most_of_rod = 150; // longer rods bend, which rigid motions do not tell
    const JointStiffness joint = at_rest_->stiffest_joint();
    const bool alone = !ranks_ || ranks_->size() == 1, joined = joint.along > 0 || joint.about > 0;
    const auto rods = static_cast<int>(rods_.size());
    return contacts_ && alone && !joined && at_rest_->common_nodes().empty() && rods >= least_rods &&
           unknowns() <= most_of_rod * rods;
}

void StaticSystem::share_rods(const Communicator& ranks) {
    const auto count = static_cast<std::size_t>(ranks.size());
    std::vector<int> columns;
    std::vector<std::size_t> slots;
    std::size_t rod = 0;
    int unknown = 0;
    for (std::size_t r = 0; r <= count; ++r) {
        while (rod < rods_.size() && first_slot(rod) * count < r * unknowns_.slots()) ++rod;
        while (unknown < unknowns() && unknowns_.place(unknown).rod < rod) ++unknown;
        columns.push_back(unknown);
        slots.push_back(first_slot(rod));
    }
    for (std::size_t r = 0; r < count; ++r)
        slots_of_ranks_.push_back(static_cast<std::int64_t>(slots[r + 1] - slots[r]));
    const auto own = static_cast<std::size_t>(ranks.rank());
    share_ = {slots[own], slots[own + 1]};
    assembly_.share(ranks, std::move(columns));
}

void StaticSystem::gather_loads() {
    constexpr std::size_t numbers = 8;
    std::vector<double> own;
    own.reserve(numbers * (share_.end - share_.first));
    for (std::size_t s = share_.first; s < share_.end; ++s) {
        const Vec3d &f = loads_.force[s], &c = loads_.couple[s];
        own.insert(own.end(), {f.x, f.y, f.z, c.x, c.y, c.z, loads_.force_size[s], loads_.couple_size[s]});
    }
    std::vector<std::int64_t> counts;
    for (const std::int64_t slots : slots_of_ranks_) counts.push_back(static_cast<std::int64_t>(numbers) * slots);
    std::vector<double> all(numbers * unknowns_.slots());
    ranks_->all_gather(own, counts, all);
    for (std::size_t s = 0; s < unknowns_.slots(); ++s) {
        const double* x = &all[numbers * s];
        loads_.force[s] = {x[0], x[1], x[2]};
        loads_.couple[s] = {x[3], x[4], x[5]};
        loads_.force_size[s] = x[6];
        loads_.couple_size[s] = x[7];
    }
}

void StaticSystem::lead_ends(StaticState& state) const {
    if (!held_.empty()) unknowns_.put_held(held_, state.slot);
    at_rest_->lead_ends(state.slot);
    unknowns_.gather(state.slot);
    refresh(state);
}

void StaticSystem::set_reference(const StaticState& state) {
    at_rest_->set_reference(state.slot);
    if (contacts_) contacts_->set_reference(state.slot);
}

void StaticSystem::keep_springs(const StaticState& state) {
    balance(state, false);
    at_rest_->keep_springs();
    if (contacts_) contacts_->keep_springs();
    set_reference(state);
}

void StaticSystem::keep_joints(StaticState& state) const {
    at_rest_->set_joint_memory(state.joint_memory);
    state.joint_memory = at_rest_->joint_memory_at(state.slot, true);
}

FrictionMemory StaticSystem::friction_memory(const StaticState& state) const {
    FrictionMemory memory;
    if (!has_history()) return memory;
    memory.reference = state.slot;
    for (std::size_t i = 0; i < rods_.size(); ++i) memory.walls.push_back(at_rest_->wall_memory(i));
    if (contacts_) memory.contacts = contacts_->springs();
    return memory;
}

void StaticSystem::set_friction_memory(const FrictionMemory& memory) {
    if (memory.empty()) return;
    for (std::size_t i = 0; i < rods_.size(); ++i)
        if (!memory.walls[i].empty()) at_rest_->set_wall_memory(i, memory.walls[i]);
    at_rest_->set_reference(memory.reference);
    if (!contacts_) return;
    contacts_->set_springs(memory.contacts);
    contacts_->set_reference(memory.reference);
}

long StaticSystem::gone(const StaticState& state, const StaticState& start, double distance) const {
    for (std::size_t s = 0; s < state.slot.size(); ++s)
        if (norm(lane(state.slot[s].position, 0) - lane(start.slot[s].position, 0)) > distance)
            return static_cast<long>(s);
    return -1;
}

double StaticSystem::extent(const StaticState& state) {
    Vec3d low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (const Slot<1>& slot : state.slot) {
        const Vec3d at = lane(slot.position, 0);
        low = {std::min(low.x, at.x), std::min(low.y, at.y), std::min(low.z, at.z)};
        high = {std::max(high.x, at.x), std::max(high.y, at.y), std::max(high.z, at.z)};
    }
    return norm(high - low);
}

double StaticSystem::lead_up_to(double from, double to, double most) const {
    constexpr int looks = 256; // within the time, as ends may go there and back
    double earliest = to;
    const auto limit = [&](auto&& turn) {
        double turned = 0;
        Vec3d last = turn(from);
        for (int look = 1; look <= looks && turned <= most; ++look) {
            const Vec3d now = turn(from + (to - from) * look / looks);
            turned += norm(now - last);
            last = now;
            if (turned > most) earliest = std::min(earliest, from + (to - from) * std::max(1, look - 1) / looks);
        }
    };
    for (const LocalRod& rod : rods_)
        for (const EndMotion* motion :
             {&nth(groups_, rod.group).spec().start_motion, &nth(groups_, rod.group).spec().end_motion})
            if (motion->turns()) limit([&](double time) { return motion->turn(time).value; });
    for (std::size_t i = 0; i < at_rest_->turning_motors(); ++i)
        limit([&](double time) { return at_rest_->motor_angle(i, time); });
    return earliest;
}

void StaticSystem::add_block(Assembly& to, std::size_t row, std::size_t column, const StiffnessBlock& block,
                             std::span<const Slot<1>> state, std::size_t count) const {
    // Whole blocks, so that the pattern is that of the couplings.
    if (unknowns_.plain(row) && unknowns_.plain(column))
        return to.add_block(row, column, unknowns_.of(row), unknowns_.of(column), block, count);
    const SlotParts rows = unknowns_.parts(row, state), columns = unknowns_.parts(column, state);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = 0; j < count; ++j) {
            if (block[i][j] == 0) continue;
            for (const UnknownPart& r : rows[i])
                for (const UnknownPart& c : columns[j]) to.add(r.unknown, c.unknown, r.factor * block[i][j] * c.factor);
        }
}

StaticSystem::Balance StaticSystem::balance(const StaticState& state, bool with_stiffness, bool convex) {
    at_rest_->set_joint_memory(state.joint_memory);
    loads_.share = touching_.share = share_;
    at_rest_->evaluate(state.slot, state.strain, with_stiffness, loads_);
    if (contacts_) contacts_->make_convex(convex);
    if (contacts_) add_contacts(state, with_stiffness);
    if (!slots_of_ranks_.empty()) gather_loads();
    Balance out;
    out.residual = gathered(loads_, state);
    out.force_size = *std::max_element(loads_.force_size.begin(), loads_.force_size.end());
    out.couple_size = *std::max_element(loads_.couple_size.begin(), loads_.couple_size.end());
    if (!with_stiffness) return out;
    out.stiffness = &assembly_.sum(unknowns(), [&] {
        add_blocks(assembly_, state);
        add_body_turns(state);
        add_turns_of_bearings(state);
    });
    out.asymmetry = assembly_.asymmetry();
    return out;
}

/// Blocks of the last evaluation: of rods, of joints and of contacts. The pattern keeps blocks that were not zero once.
void StaticSystem::add_blocks(Assembly& to, const StaticState& state) const {
    const auto counts = [&](std::size_t row, std::size_t column, const StiffnessBlock& block) {
        return to.expects_block(row, column) || !is_zero(block);
    };
    for (std::size_t i = 0; i < rods_.size(); ++i) {
        const RodGroup& own = group(i);
        const std::size_t first = first_slot(i);
        if (!loads_.share.has(first)) continue;
        const long nodes = own.nodes(), slots = own.slots();
        for (long k = 0; k < nodes; ++k) {
            const std::size_t row = first + static_cast<std::size_t>(k);
            for (int offset = -StiffnessRow::reach; offset <= StiffnessRow::reach; ++offset) {
                long at = k + offset;
                if (own.closed()) at = (at + 2 * nodes) % nodes;
                if (at < 0 || at >= slots) continue;
                const std::size_t column = first + static_cast<std::size_t>(at);
                if (const StiffnessBlock& block = loads_.row[row].at(offset); counts(row, column, block))
                    add_block(to, row, column, block, state.slot);
            }
        }
    }
    const auto is_asked = [&](const SlotCoupling& c) { return loads_.share.has(c.column); };
    for (const SlotCoupling& c : loads_.couplings)
        if (is_asked(c) && counts(c.row, c.column, c.block)) add_block(to, c.row, c.column, c.block, state.slot);
    if (!contacts_) return;
    for (const SlotCoupling& c : touching_.couplings)
        if (is_asked(c)) add_block(to, c.row, c.column, c.block, state.slot, 3);
    for (const SlotCoupling& c : touching_.turning)
        if (is_asked(c)) add_block(to, c.row, c.column, c.block, state.slot);
}

Stiffness StaticSystem::damping(const StaticState& state) {
    at_rest_->set_joint_memory(state.joint_memory);
    loads_.share = touching_.share = {};
    at_rest_->evaluate_damping(state.slot, loads_);
    if (contacts_) contacts_->evaluate_damping(state.slot, touching_);
    Assembly all;
    Stiffness damping = all.sum(unknowns(), [&] { add_blocks(all, state); });
    damping.prune([](Eigen::Index, Eigen::Index, double value) { return value != 0; });
    return damping;
}

void StaticSystem::leave_couples(Balance& balance, const Unknown& left) const {
    for (std::size_t s = 0; s < unknowns_.slots(); ++s) {
        if (!unknowns_.plain(s)) continue;
        const int at[3] = {unknowns_.of(s, 3), unknowns_.of(s, 4), unknowns_.of(s, 5)};
        if (std::any_of(std::begin(at), std::end(at), [](int u) { return u < 0; })) continue;
        for (const int i : {0, 1, 2}) {
            const int j = (i + 1) % 3;
            const double half = 0.5 * left[at[(i + 2) % 3]];
            if (half == 0) continue;
            balance.stiffness->coeffRef(at[i], at[j]) += half;
            balance.stiffness->coeffRef(at[j], at[i]) -= half;
        }
    }
}

Unknown StaticSystem::gathered(const StaticLoads& loads, const StaticState& state) const {
    Unknown all = Unknown::Zero(unknowns());
    for (std::size_t s = 0; s < unknowns_.slots(); ++s) {
        const Vec3d &f = loads.force[s], &c = loads.couple[s];
        const double load[slot_unknowns] = {f.x, f.y, f.z, c.x, c.y, c.z};
        if (unknowns_.plain(s)) {
            for (std::size_t i = 0; i < slot_unknowns; ++i)
                if (const int at = unknowns_.of(s, i); at >= 0) all[at] += load[i];
            continue;
        }
        const SlotParts parts = unknowns_.parts(s, state.slot);
        for (std::size_t i = 0; i < slot_unknowns; ++i)
            for (const UnknownPart& part : parts[i]) all[part.unknown] += part.factor * load[i];
    }
    return all;
}

std::pair<StaticSystem::Balance, double> StaticSystem::sticking_balance(const StaticState& state) {
    const auto take_friction = [&](bool acts) {
        at_rest_->take_friction(acts);
        if (contacts_) contacts_->take_friction(acts);
    };
    constexpr double round_off = 1e-9;
    bool potential = false; // of all other loads
    if (rubs()) {
        take_friction(false);
        potential = balance(state, true).asymmetry < round_off;
        take_friction(true);
    }
    std::pair<Balance, double> out{balance(state, true), 0.0};
    if (!potential) return out;
    out.second = std::exchange(out.first.asymmetry, 0.0);
    assembly_.take_symmetric_part();
    return out;
}

void StaticSystem::add_contacts(const StaticState& state, bool with_stiffness) {
    contacts_->evaluate(state.slot, with_stiffness, touching_);
    for (std::size_t s = 0; s < loads_.force.size(); ++s) {
        loads_.force[s] = loads_.force[s] + touching_.force[s];
        loads_.couple[s] = loads_.couple[s] + touching_.couple[s];
        loads_.force_size[s] += touching_.force_size[s];
        loads_.couple_size[s] += touching_.couple_size[s];
    }
}

/// A force on a node of a body has a moment that turns with it.
void StaticSystem::add_body_turns(const StaticState& state) {
    for (const CommonNode& node : at_rest_->common_nodes()) {
        if (!node.on_body) continue;
        StiffnessBlock block{};
        add_turn_of_arm(node.arm, lane(state.slot[node.master].director, 0) * loads_.force[node.slot], block);
        if (!is_zero(block)) add_block(assembly_, node.master, node.master, block, state.slot);
    }
}

/// A bearing answers the couple about its lab axis, and turns across this axis do not commute.     theory.md (97)
void StaticSystem::add_turns_of_bearings(const StaticState& state) {
    for (const std::size_t s : unknowns_.held_about_one()) {
        if (!loads_.share.has(s)) continue;
        const Vec3d c = transpose_times(lane(state.slot[s].director, 0), loads_.couple[s]);
        const double couple[3] = {c.x, c.y, c.z};
        for (const std::size_t held : {0U, 1U, 2U}) {
            if (unknowns_.of(s, 3 + held) >= 0) continue;
            const int i = unknowns_.of(s, 3 + (held + 1) % 3), j = unknowns_.of(s, 3 + (held + 2) % 3);
            assembly_.add(i, j, -0.5 * couple[held]);
            assembly_.add(j, i, 0.5 * couple[held]);
        }
    }
}

double StaticSystem::relative(const Balance& balance) const {
    double largest = 0;
    const double force = std::max({balance.force_size, balance.couple_size / length_, least_force_, 1e-300}),
                 couple =
                     std::max({balance.couple_size, balance.force_size * element_, least_force_ * length_, 1e-300});
    for (int i = 0; i < unknowns(); ++i) {
        const double size = unknowns_.place(i).i < 3 ? force : couple;
        largest = std::max(largest, std::abs(balance.residual[i]) / size);
    }
    return largest;
}

double StaticSystem::size(const Unknown& correction) const {
    double largest = 0;
    for (int i = 0; i < unknowns(); ++i)
        largest = std::max(largest, std::abs(correction[i]) / (unknowns_.place(i).i < 3 ? length_ : 1));
    return largest;
}

double StaticSystem::clear_share(const StaticState& state, const Unknown& correction, double share) const {
    if (!contacts_) return share;
    std::vector<Slot<1>> moved = state.slot;
    unknowns_.apply(moves(correction, state), share, moved);
    return share * contacts_->clear_share(state.slot, moved);
}

double StaticSystem::turn(const Unknown& correction) const {
    double largest = 0;
    for (int i = 0; i < unknowns(); ++i)
        if (unknowns_.place(i).i >= 3) largest = std::max(largest, std::abs(correction[i]));
    return largest;
}

void StaticSystem::correct(StaticState& state, const Unknown& correction, double share) const {
    const Unknowns::Moves moves = this->moves(correction, state);
    // The carried strain goes to the linear one of the new state.
    const std::vector<Vec3d> now = at_rest_->strains(state.slot);
    for (std::size_t i = 0; i < rods_.size(); ++i) {
        const RodGroup& own = group(i);
        if (!own.strained()) continue;
        const std::size_t first = first_slot(i);
        for (int k = 0; k < own.elements(); ++k) {
            const std::size_t s = first + to_index(k);
            const double l = norm(lane(state.slot[s + 1].position, 0) - lane(state.slot[s].position, 0)) / norm(now[s]);
            const Vec3d change = (1 / l) * (lane(state.slot[s].director, 0) * (moves.node[s + 1] - moves.node[s])) +
                                 cross(now[s], moves.turn[s]);
            state.strain[s] = state.strain[s] + share * (now[s] + change - state.strain[s]);
        }
    }
    unknowns_.apply(moves, share, state.slot);
    if (state.joint_memory.empty()) return;
    at_rest_->set_joint_memory(state.joint_memory);
    state.joint_memory = at_rest_->joint_memory_at(state.slot, false);
}

Stiffness StaticSystem::mass(const StaticState& state) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t i = 0; i < rods_.size(); ++i)
        with_rod(group(i), rods_[i].index, [&](const RodGroup& own) {
            for (int k = 0; k < own.slots(); ++k) {
                const std::size_t s = first_slot(i) + to_index(k);
                const double m = nth(own.node_mass, k);
                const Vec3d j = k < own.elements() ? nth(own.element, k).inertia : Vec3d{0, 0, 0};
                const double inertia[slot_unknowns] = {m, m, m, j.x, j.y, j.z};
                const SlotParts parts = unknowns_.parts(s, state.slot);
                for (std::size_t u = 0; u < slot_unknowns; ++u)
                    for (const UnknownPart& a : parts[u])
                        for (const UnknownPart& b : parts[u])
                            entries.emplace_back(a.unknown, b.unknown, a.factor * inertia[u] * b.factor);
            }
        });
    Stiffness mass(unknowns(), unknowns());
    mass.setFromTriplets(entries.begin(), entries.end());
    return mass;
}

Unknown StaticSystem::axial_spin(const StaticState& state) const {
    constexpr double round_off = 1e-9;
    Unknown spin = Unknown::Zero(unknowns());
    for (int u = 0; u < unknowns(); ++u) {
        const Unknowns::Place place = unknowns_.place(u);
        const Vec3d rate = lane(slot(u, state).spin, 0);
        if (place.i != 5 || rate.z == 0 || !is_round(group(place.rod))) continue;
        if (std::hypot(rate.x, rate.y) > round_off * std::abs(rate.z)) return {};
        spin[u] = rate.z;
    }
    return spin.isZero(0) ? Unknown() : spin;
}

Stiffness StaticSystem::gyroscopic(const Unknown& spin) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (int u = 2; u < spin.size(); ++u) {
        const Unknowns::Place place = unknowns_.place(u), first = unknowns_.place(u - 2);
        // Turns about d1 and d2 of the same element, or none.
        if (spin[u] == 0 || first.rod != place.rod || first.slot != place.slot || first.i != 3) continue;
        with_rod(group(place.rod), rods_[place.rod].index, [&](const RodGroup& own) {
            const double momentum = nth(own.element, place.slot).inertia.z * spin[u];
            entries.emplace_back(u - 2, u - 1, momentum);
            entries.emplace_back(u - 1, u - 2, -momentum);
        });
    }
    Stiffness gyroscopic(unknowns(), unknowns());
    gyroscopic.setFromTriplets(entries.begin(), entries.end());
    return gyroscopic;
}

std::string StaticSystem::rod_name(std::size_t rod) const {
    const RodGroup& own = group(rod);
    return own.count() > 1 ? fmt::format("rod {} of '{}'", rods_[rod].index, own.name())
                           : fmt::format("'{}'", own.name());
}

StaticState start_of(const StaticSystem& system, std::span<const RodGroup> groups, std::span<const LocalRod> rods) {
    StaticState state;
    for (const LocalRod& rod : rods) {
        const RodGroup& group = nth(groups, rod.group);
        std::vector<Slot<1>> one(to_index(group.slots()));
        group.start_state(rod.index, one);
        state.slot.insert(state.slot.end(), one.begin(), one.end());
    }
    system.map().gather(state.slot);
    system.refresh(state);
    return state;
}

} // namespace skein
