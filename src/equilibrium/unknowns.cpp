#include "equilibrium/unknowns.hpp"

#include "core/rotation.hpp"
#include "mechanics/rod_copies.hpp"
#include "rod/slot_freedom.hpp"

#include <algorithm>

namespace skein {

Unknowns::Unknowns(std::span<const RodGroup> groups, std::span<const LocalRod> rods, const StaticRods& at_rest)
    : shared_(at_rest.common_nodes().begin(), at_rest.common_nodes().end()) {
    const std::size_t slots = at_rest.first_slot(rods.size());
    number_.assign(slots, {0, 0, 0, 0, 0, 0}); // 0: free, -1: held
    turned_.assign(slots, 0);
    on_body_.assign(slots, -1);
    rod_of_slot_.resize(slots);
    for (std::size_t i = 0; i < rods.size(); ++i) {
        const RodGroup& group = nth(groups, rods[i].group);
        const std::size_t first = at_rest.first_slot(i);
        if (group.closed()) shared_.push_back({first + to_index(group.elements()), first, false, {}});
        number_rod(group, i, first);
    }
    // A common node is held where one of its members is.
    for (std::size_t j = 0; j < shared_.size(); ++j) {
        const CommonNode& node = shared_[j];
        if (node.on_body) on_body_[node.slot] = static_cast<long>(j);
        else
            for (std::size_t i = 0; i < 3; ++i)
                number_[node.master][i] = std::min(number_[node.master][i], number_[node.slot][i]);
    }
    std::vector<unsigned char> led(slots, 0);
    for (const CommonNode& node : shared_) led[node.slot] = 1;
    for (std::size_t s = 0; s < slots; ++s)
        for (std::size_t i = 0; i < slot_unknowns; ++i)
            if (number_[s][i] == 0 && !(i < 3 && led[s])) {
                number_[s][i] = count_++;
                place_.push_back(
                    {rod_of_slot_[s], static_cast<int>(s - at_rest.first_slot(rod_of_slot_[s])), static_cast<int>(i)});
            }
    for (const CommonNode& node : shared_)
        for (std::size_t i = 0; i < 3; ++i) number_[node.slot][i] = node.on_body ? -1 : number_[node.master][i];
}

void Unknowns::number_rod(const RodGroup& group, std::size_t rod, std::size_t first) {
    const std::vector<SlotFreedom> freedom = slot_freedoms(group);
    for (std::size_t k = 0; k < freedom.size(); ++k) {
        rod_of_slot_[first + k] = rod;
        turned_[first + k] = freedom[k].turns_in_lab;
        if (freedom[k].only_held_axis() >= 0) held_about_one_.push_back(first + k);
        for (std::size_t i = 0; i < slot_unknowns; ++i)
            if (freedom[k].free[i] == 0) number_[first + k][i] = -1;
    }
}

SlotParts Unknowns::parts(std::size_t slot, std::span<const Slot<1>> state) const {
    SlotParts parts;
    const auto& number = number_[slot];
    for (std::size_t i = 0; i < slot_unknowns; ++i)
        if (number[i] >= 0 && !(i >= 3 && turned_[slot])) parts[i] = {{number[i], 1.0}};
    if (turned_[slot]) { // t = Q u
        const Mat3d q = matrix(lane(state[slot].director, 0));
        const Vec3d rows[3] = {q.d1, q.d2, q.d3};
        for (std::size_t i = 0; i < 3; ++i) {
            const double row[3] = {rows[i].x, rows[i].y, rows[i].z};
            for (std::size_t j = 0; j < 3; ++j)
                if (number[3 + j] >= 0) parts[3 + i].push_back({number[3 + j], row[j]});
        }
    }
    if (on_body_[slot] >= 0) { // x = X + Q^T a:  dx = dX + Q^T (t x a)
        const CommonNode& node = shared_[static_cast<std::size_t>(on_body_[slot])];
        const Quaterniond q = lane(state[node.master].director, 0);
        const auto& body = number_[node.master];
        const Vec3d units[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        for (std::size_t i = 0; i < 3; ++i)
            if (body[i] >= 0) parts[i].push_back({body[i], 1.0});
        for (std::size_t j = 0; j < 3; ++j) {
            if (body[3 + j] < 0) continue;
            const Vec3d by = transpose_times(q, cross(units[j], node.arm));
            const double column[3] = {by.x, by.y, by.z};
            for (std::size_t i = 0; i < 3; ++i) parts[i].push_back({body[3 + j], column[i]});
        }
    }
    return parts;
}

Unknowns::Moves Unknowns::moves(std::span<const double> correction, std::span<const Slot<1>> state) const {
    Moves moves{std::vector<Vec3d>(slots()), std::vector<Vec3d>(slots())};
    for (std::size_t s = 0; s < slots(); ++s) {
        double u[slot_unknowns] = {};
        if (plain(s)) {
            for (std::size_t i = 0; i < slot_unknowns; ++i)
                if (const int at = number_[s][i]; at >= 0) u[i] = correction[static_cast<std::size_t>(at)];
        } else {
            const SlotParts all = parts(s, state);
            for (std::size_t i = 0; i < slot_unknowns; ++i)
                for (const UnknownPart& part : all[i])
                    u[i] += part.factor * correction[static_cast<std::size_t>(part.unknown)];
        }
        moves.node[s] = {u[0], u[1], u[2]};
        moves.turn[s] = {u[3], u[4], u[5]};
    }
    return moves;
}

void Unknowns::apply(const Moves& moves, double share, std::span<Slot<1>> state) const {
    for (std::size_t s = 0; s < slots(); ++s) {
        set_lane(state[s].position, 0, lane(state[s].position, 0) + share * moves.node[s]);
        if (zero(moves.turn[s])) continue;
        const Quaterniond q = rotation(share * moves.turn[s]) * lane(state[s].director, 0);
        const double scale = 1 / std::sqrt(dot(q, q));
        set_lane(state[s].director, 0, Quaterniond{scale * q.w, scale * q.v});
    }
    gather(state);
}

void Unknowns::put_held(std::span<const Slot<1>> from, std::span<Slot<1>> to) const {
    for (std::size_t s = 0; s < slots(); ++s) {
        const auto& number = number_[s];
        Vec3d place = lane(to[s].position, 0);
        const Vec3d held = lane(from[s].position, 0);
        if (number[0] < 0) place.x = held.x;
        if (number[1] < 0) place.y = held.y;
        if (number[2] < 0) place.z = held.z;
        set_lane(to[s].position, 0, place);
        if (number[3] < 0 && number[4] < 0 && number[5] < 0) set_lane(to[s].director, 0, lane(from[s].director, 0));
    }
}

void Unknowns::gather(std::span<Slot<1>> state) const {
    for (const CommonNode& node : shared_) {
        const Slot<1>& master = state[node.master];
        Vec3d at = lane(master.position, 0);
        if (node.on_body) at = at + transpose_times(lane(master.director, 0), node.arm);
        set_lane(state[node.slot].position, 0, at);
    }
}

} // namespace skein
