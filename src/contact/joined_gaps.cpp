#include "contact/joined_gaps.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

namespace skein {

JoinedGaps::JoinedGaps(std::span<const RodGroup> groups, double gap) : gap_(gap) {
    for (const RodGroup& group : groups) {
        Group& of = groups_.emplace_back(Group{group.first_gid(), group.rods_per_copy(), {}, group.closed()});
        for_each_kind(group, [&](const RodGroup& kind, double) {
            Line& line = of.lines.emplace_back();
            if (!kind.strained()) return;
            line.arc.push_back(0);
            for (const ElementConstants& c : kind.element) {
                line.arc.push_back(line.arc.back() + c.rest_length);
                line.half_round = std::max(line.half_round, std::numbers::pi * c.radius);
            }
        });
    }
}

std::int64_t JoinedGaps::in_first_copy(int group, std::int64_t gid) const {
    const Group& of = nth(groups_, group);
    return of.first_gid + (gid - of.first_gid) % of.rods_per_copy;
}

JoinedGaps::Met JoinedGaps::met(const JoinedPlace& place, std::size_t set) const {
    const std::vector<double>& arc = nth(groups_, place.group).line(place.rod).arc;
    const auto at = [&](int node) { return arc.empty() ? 0 : nth(arc, node); };
    return {place.group, place.rod, at(place.element) + place.share * (at(place.element + 1) - at(place.element)),
            place.arm, set};
}

void JoinedGaps::add(const JoinedPlace& a, const JoinedPlace& b) {
    const std::size_t set = met_.size();
    met_.push_back(met(a, set));
    met_.push_back(met(b, set));
}

/// True for two places of one body that are no farther apart than its gap.
bool JoinedGaps::near(const Met& a, const Met& b) const {
    if (a.group != b.group || a.rod != b.rod) return false;
    const Line& line = nth(groups_, a.group).line(a.rod);
    return std::max(std::abs(a.arc - b.arc), norm(a.arm - b.arm)) <= gap_of(line, line);
}

void JoinedGaps::settle() {
    std::sort(met_.begin(), met_.end(), [](const Met& x, const Met& y) {
        return std::tie(x.group, x.rod, x.arc) < std::tie(y.group, y.rod, y.arc);
    });
    std::vector<std::size_t> into(met_.size());
    std::iota(into.begin(), into.end(), std::size_t{0});
    const auto root = [&](std::size_t set) {
        while (into[set] != set) set = into[set] = into[into[set]];
        return set;
    };
    for (std::size_t i = 0; i < met_.size(); ++i)
        for (std::size_t k = i + 1; k < met_.size() && near(met_[i], met_[k]); ++k)
            into[root(met_[k].set)] = root(met_[i].set);
    std::map<std::size_t, std::vector<const Met*>> sets;
    for (const Met& one : met_) sets[root(one.set)].push_back(&one);
    const auto body = [&](const Met& p) { return nth(groups_, p.group).first_gid + p.rod; };
    for (const auto& [set, places] : sets)
        for (std::size_t i = 0; i < places.size(); ++i)
            for (std::size_t k = i + 1; k < places.size(); ++k) {
                const Met &x = *places[i], &y = *places[k];
                if (body(x) < body(y)) joints_[{body(x), body(y)}].push_back({x.arc, y.arc});
                if (body(y) < body(x)) joints_[{body(y), body(x)}].push_back({y.arc, x.arc});
            }
    met_.clear();
}

/// Way along a body from a joint to the nearest point of an element, m.
double JoinedGaps::way(const Line& line, bool closed, std::int64_t element, double arc) {
    if (line.arc.empty()) return 0;
    const double length = line.arc.back(), begin = nth(line.arc, element), end = nth(line.arc, element + 1);
    const double straight = std::max({0.0, begin - arc, arc - end});
    if (!closed) return straight;
    return std::min({straight, std::abs(begin + length - arc), std::abs(arc + length - end)});
}

bool JoinedGaps::may_touch(const Exposure& bodies, std::size_t a, std::size_t b) const {
    const auto body = [&](std::size_t slot) { return in_first_copy(bodies.at(slot).group, bodies.at(slot).gid); };
    if (body(a) > body(b)) std::swap(a, b);
    const auto found = joints_.find({body(a), body(b)});
    if (found == joints_.end()) return true;
    const Group &of_a = nth(groups_, bodies.at(a).group), &of_b = nth(groups_, bodies.at(b).group);
    const Line &line_a = of_a.line(body(a) - of_a.first_gid), &line_b = of_b.line(body(b) - of_b.first_gid);
    const double gap = gap_of(line_a, line_b);
    return std::all_of(found->second.begin(), found->second.end(), [&](const Arcs& joint) {
        return way(line_a, of_a.closed, bodies.element(a), joint.a) +
                   way(line_b, of_b.closed, bodies.element(b), joint.b) >
               gap;
    });
}

} // namespace skein
