#include "contact/joined_gaps.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

JoinedGaps::JoinedGaps(std::span<const RodGroup> groups, double gap) : gap_(gap) {
    for (const RodGroup& group : groups) {
        Group& of = groups_.emplace_back(Group{group.first_gid(), group.rods_per_copy(), {}, 0, group.closed()});
        if (!group.strained()) continue;
        of.arc.push_back(0);
        for (const ElementConstants& c : group.element) {
            of.arc.push_back(of.arc.back() + c.rest_length);
            of.half_round = std::max(of.half_round, std::numbers::pi * c.radius);
        }
    }
}

std::int64_t JoinedGaps::in_first_copy(int group, std::int64_t gid) const {
    const Group& of = nth(groups_, group);
    return of.first_gid + (gid - of.first_gid) % of.rods_per_copy;
}

void JoinedGaps::add(const JoinedPlace& a, const JoinedPlace& b) {
    const std::int64_t of_a = nth(groups_, a.group).first_gid + a.rod, of_b = nth(groups_, b.group).first_gid + b.rod;
    if (of_a < of_b) joints_[{of_a, of_b}].push_back({a.arc, b.arc});
    else joints_[{of_b, of_a}].push_back({b.arc, a.arc});
}

/// Way along a body from a joint to the nearest point of an element, m.
double JoinedGaps::way(const Group& group, std::int64_t element, double arc) {
    if (group.arc.empty()) return 0;
    const double length = group.arc.back(), begin = nth(group.arc, element), end = nth(group.arc, element + 1);
    const double straight = std::max({0.0, begin - arc, arc - end});
    if (!group.closed) return straight;
    return std::min({straight, std::abs(begin + length - arc), std::abs(arc + length - end)});
}

bool JoinedGaps::may_touch(const Exposure& bodies, std::size_t a, std::size_t b) const {
    const auto body = [&](std::size_t slot) { return in_first_copy(bodies.at(slot).group, bodies.at(slot).gid); };
    if (body(a) > body(b)) std::swap(a, b);
    const auto found = joints_.find({body(a), body(b)});
    if (found == joints_.end()) return true;
    const Group &of_a = nth(groups_, bodies.at(a).group), &of_b = nth(groups_, bodies.at(b).group);
    const double gap = gap_ > 0 ? gap_ : std::max(of_a.half_round, of_b.half_round);
    return std::all_of(found->second.begin(), found->second.end(), [&](const Arcs& joint) {
        return way(of_a, bodies.element(a), joint.a) + way(of_b, bodies.element(b), joint.b) > gap;
    });
}

} // namespace skein
