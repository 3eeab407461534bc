#include "joints/joint_list.hpp"

#include "joints/joint_events.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <unordered_map>

namespace skein {

namespace {

/// A group's rods in a copy, where they start, in the axes of the assembly.
class Member {
public:
    Member(const RodGroup& group) : group_(group), rods_(group.rods_per_copy()) {
        const auto slots = static_cast<std::size_t>(group.slots());
        state_.resize(static_cast<std::size_t>(rods_) * slots);
        for (std::int64_t i = 0; i < rods_; ++i)
            group.start_state_in_assembly(i, std::span(state_).subspan(static_cast<std::size_t>(i) * slots, slots));
    }
    const RodGroup& group() const { return group_; }
    std::int64_t rods() const { return rods_; }
    int elements() const { return group_.elements(); }
    Quaterniond director(std::int64_t rod, int k) const { return lane(slot(rod, k).director, 0); }
    Vec3d node(std::int64_t rod, int k) const { return lane(slot(rod, k).position, 0); }
    /// Between the nodes of an element; of a body its centre.
    Vec3d place(std::int64_t rod, int k, double share) const {
        return group_.strained() ? (1 - share) * node(rod, k) + share * node(rod, k + 1) : node(rod, k);
    }
    double radius(std::int64_t rod, int k) const { return nth(group_.kind(rod).element, k).radius; }
    double largest_radius() const {
        double most = 0;
        for_each_kind(group_, [&](const RodGroup& rod, double) {
            for (const ElementConstants& e : rod.element) most = std::max(most, e.radius);
        });
        return most;
    }

    /// The point `to` as it moves with an element.
    JointEnd end(std::int64_t rod, int k, double share, const Vec3d& to) const {
        const Vec3d off = to - place(rod, k, share);
        const bool none = norm(off) <= 1e-12 * nth(group_.kind(rod).element, k).rest_length; // rounding
        return {group_.id(), rod, k, group_.strained() ? share : 0, none ? Vec3d{0, 0, 0} : director(rod, k) * off,
                {0, 0, 0}};
    }
    /// The element at a share of the length, and the share of it that is before this place.
    std::pair<int, double> at(std::int64_t rod, double share_of_length) const {
        if (!group_.strained()) return {0, 0.0};
        const RodGroup& own = group_.kind(rod);
        const int n = elements();
        double left = share_of_length * own.spec().shape.length;
        for (int k = 0; k < n; ++k) {
            const double length = nth(own.element, k).rest_length;
            if (left <= length * (1 + 1e-9) || k == n - 1) return {k, std::clamp(left / length, 0.0, 1.0)};
            left -= length;
        }
        return {n - 1, 1.0};
    }

private:
    const Slot<1>& slot(std::int64_t rod, int k) const {
        return state_[static_cast<std::size_t>(rod) * static_cast<std::size_t>(group_.slots()) +
                      static_cast<std::size_t>(k)];
    }
    const RodGroup& group_;
    std::int64_t rods_;
    std::vector<Slot<1>> state_;
};

/// The elements of a member by the cells of a grid that their centres lie in.
class ElementGrid {
public:
    ElementGrid(const Member& member, double cell) : cell_(cell) {
        for (std::int64_t rod = 0; rod < member.rods(); ++rod)
            for (int k = 0; k < member.elements(); ++k)
                cells_[key(cell_at(member.place(rod, k, 0.5)))].push_back({rod, k});
    }
    struct Element {
        std::int64_t rod;
        int number;
    };
    /// Calls f for all elements whose centres are within a cell of a place, in some order.
    template <class F> void near(const Vec3d& place, F&& f) const {
        const auto [x, y, z] = cell_at(place);
        for (const long dx : {-1, 0, 1})
            for (const long dy : {-1, 0, 1})
                for (const long dz : {-1, 0, 1})
                    if (const auto found = cells_.find(key({x + dx, y + dy, z + dz})); found != cells_.end())
                        for (const Element& element : found->second) f(element);
    }

private:
    using Cell = std::tuple<long, long, long>;
    Cell cell_at(const Vec3d& p) const {
        return {std::lround(std::floor(p.x / cell_)), std::lround(std::floor(p.y / cell_)),
                std::lround(std::floor(p.z / cell_))};
    }
    static std::uint64_t key(const Cell& c) {
        const auto bits = [](long i) { return static_cast<std::uint64_t>(i + (1 << 20)) & 0x1fffff; };
        return bits(std::get<0>(c)) << 42 | bits(std::get<1>(c)) << 21 | bits(std::get<2>(c));
    }
    double cell_;
    std::unordered_map<std::uint64_t, std::vector<Element>> cells_;
};

/// The joints of one table.
class JointMaker {
public:
    JointMaker(std::size_t table, const JointSpec& spec, const RodGroup& first, const RodGroup& second)
        : table_(table), spec_(spec), first_(first), second_(second), same_(first.id() == second.id()) {}

    /// Joints of rods of the first group to the world.
    std::vector<Joint> make_to_world() {
        if (spec_.pairs == JointPairs::listed)
            for (const long i : spec_.first) {
                if (i >= first_.rods())
                    refuse(fmt::format("lists rod {}, but a copy has {}, counted from 0", i, first_.rods()));
                to_world(i);
            }
        else
            for (std::int64_t i = 0; i < first_.rods(); ++i) to_world(i);
        return finished();
    }

    std::vector<Joint> make() {
        switch (spec_.kind) {
        case JointKind::side_by_side:
            side_by_side();
            break;
        case JointKind::tip_to_side:
            for (std::int64_t rod = 0; rod < first_.rods(); ++rod) tip_to_side(rod);
            break;
        default:
            points();
        }
        if (joints_.empty()) refuse("joins nothing: no element of one is beside one of the other");
        return finished();
    }

private:
    [[noreturn]] void refuse(const std::string& what) const {
        throw InputError(fmt::format("{}: the joint between '{}' and '{}' {}", spec_.source, spec_.between[0],
                                     spec_.between[1], what));
    }
    std::vector<Joint> finished() {
        if (spec_.place && joints_.size() > 1)
            refuse(fmt::format("has one 'place' for {} joints: list one pair, or leave it out", joints_.size()));
        return std::move(joints_);
    }
    void add(JointEnd a, JointEnd b) {
        const double apart = norm(second_.place(b.rod, b.element, 0.5) - first_.place(a.rod, a.element, 0.5));
        const Quaterniond rest = second_.director(b.rod, b.element) * inverse(first_.director(a.rod, a.element));
        joints_.push_back({table_, a, b, rest, apart});
    }

    void points() {
        if (spec_.pairs == JointPairs::listed) {
            for (std::size_t i = 0; i < spec_.first.size(); ++i) {
                if (spec_.first[i] >= first_.rods() || spec_.second[i] >= second_.rods())
                    refuse(fmt::format("lists rods {} and {}, but a copy has {} and {} of them, counted from 0",
                                       spec_.first[i], spec_.second[i], first_.rods(), second_.rods()));
                point(spec_.first[i], spec_.second[i]);
            }
            return;
        }
        const std::int64_t step = spec_.pairs == JointPairs::next;
        if (same_ && step == 0)
            refuse("would join every rod with itself: 'pairs' is \"next\" or \"listed\" within a group");
        if (!same_ && first_.rods() != second_.rods())
            refuse(fmt::format("pairs rods by number, but a copy has {} and {} of them: list them", first_.rods(),
                               second_.rods()));
        for (std::int64_t i = 0; i + step < first_.rods(); ++i) point(i, i + step);
    }
    void point(std::int64_t i, std::int64_t j) {
        if (same_ && i == j) refuse(fmt::format("joins rod {} with itself", i));
        const auto [k, s] = first_.at(i, spec_.at[0]);
        const auto [l, t] = second_.at(j, spec_.at[1]);
        const Vec3d x = first_.place(i, k, s), y = second_.place(j, l, t);
        const Vec3d place = spec_.place                                                ? *spec_.place
                            : !first_.group().strained() && second_.group().strained() ? y
                            : first_.group().strained() && !second_.group().strained() ? x
                                                                                       : 0.5 * (x + y);
        const bool apart = spec_.kind == JointKind::distance;
        JointEnd a = first_.end(i, k, s, apart ? x : place), b = second_.end(j, l, t, apart ? y : place);
        if (has_axis(spec_.kind)) {
            a.axis = first_.director(i, k) * unit(spec_.axis);
            b.axis = second_.director(j, l) * second_axis();
        }
        if (spec_.kind == JointKind::spherical) set_twist(a, b, first_.director(i, k), 1);
        add(a, b);
        if (apart) joints_.back().rest_distance = length_between(x, y);
    }

    /// Directions of a spherical joint, both fixed in the first side.
    void set_twist(JointEnd& a, JointEnd& b, const Quaterniond& director, double sign) const {
        a.axis = director * (sign * spec_.twist_axis());
        b.axis = director * (sign * spec_.across_twist());
    }
    /// Direction that is fixed in the second side: the axis, of universal joints the other one.
    Vec3d second_axis() const { return unit(spec_.kind == JointKind::universal ? spec_.second_axis : spec_.axis); }
    double length_between(const Vec3d& x, const Vec3d& y) const {
        const double length = spec_.length > 0 ? spec_.length : norm(y - x);
        if (!(norm(y - x) > 0))
            refuse("keeps a distance of 0 m at the start: its two points need a direction; use a spherical joint");
        return length;
    }

    void to_world(std::int64_t i) {
        const auto [k, s] = first_.at(i, spec_.at[0]);
        const Vec3d x = spec_.place.value_or(first_.place(i, k, s));
        JointEnd a = first_.end(i, k, s, x), b{JointEnd::world, 0, 0, 0, x, {0, 0, 0}};
        if (has_axis(spec_.kind)) {
            b.axis = -second_axis(); // angles and ways are those of the rod against the world
            a.axis = first_.director(i, k) * -unit(spec_.axis);
        }
        if (spec_.kind == JointKind::spherical) set_twist(a, b, first_.director(i, k), -1);
        const bool apart = spec_.kind == JointKind::distance;
        if (apart) a = first_.end(i, k, s, first_.place(i, k, s));
        joints_.push_back(
            {table_, a, b, inverse(first_.director(i, k)), apart ? length_between(first_.place(i, k, s), x) : 0});
    }

    void side_by_side() {
        const auto with_gap = [&](double radii) { return radii + (spec_.gap > 0 ? spec_.gap : 0.005 * radii); };
        const ElementGrid grid(second_, with_gap(first_.largest_radius() + second_.largest_radius()));
        std::vector<ElementGrid::Element> found;
        for (std::int64_t i = 0; i < first_.rods(); ++i)
            for (int k = 0; k < first_.elements(); ++k) {
                const Vec3d x = first_.place(i, k, 0.5);
                found.clear();
                grid.near(x, [&](const ElementGrid::Element& e) {
                    if (same_ && e.rod <= i) return;
                    const double most = with_gap(first_.radius(i, k) + second_.radius(e.rod, e.number));
                    if (norm(second_.place(e.rod, e.number, 0.5) - x) <= most) found.push_back(e);
                });
                std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
                    return std::tie(a.rod, a.number) < std::tie(b.rod, b.number);
                });
                for (const auto& [j, l] : found) {
                    const Vec3d y = second_.place(j, l, 0.5), way = y - x;
                    const double apart = norm(way), radius = first_.radius(i, k),
                                 between = apart - radius - second_.radius(j, l);
                    const Vec3d place = x + ((radius + 0.5 * between) / apart) * way;
                    add(first_.end(i, k, 0.5, place), second_.end(j, l, 0.5, place));
                }
            }
    }

    void tip_to_side(std::int64_t i) {
        const int n = first_.elements(), k = spec_.at[0] == 0 ? 0 : n - 1;
        const Vec3d tip = first_.place(i, k, spec_.at[0]), way = first_.place(i, k, 1) - first_.place(i, k, 0);
        double nearest = HUGE_VAL, share = 0;
        ElementGrid::Element side{0, 0};
        for (std::int64_t j = 0; j < second_.rods(); ++j)
            for (int l = 0; l < second_.elements(); ++l) {
                if (same_ && i == j) continue;
                const Vec3d start = second_.place(j, l, 0), edge = second_.place(j, l, 1) - start;
                const double t = std::clamp(dot(tip - start, edge) / dot(edge, edge), 0.0, 1.0);
                const double apart = norm(tip - (start + t * edge));
                if (apart < nearest * (1 - 1e-9)) {
                    nearest = apart;
                    share = t;
                    side = {j, l};
                }
            }
        const double radius = second_.radius(side.rod, side.number);
        if (nearest > radius + first_.radius(i, k) + spec_.gap)
            refuse(fmt::format(
                "has a tip, of rod {}, that is {:.3g} m away from the axis of any other, whose radius is {:.3g} m", i,
                nearest, radius));
        JointEnd a = first_.end(i, k, spec_.at[0], tip), b = second_.end(side.rod, side.number, share, tip);
        a.axis = first_.director(i, k) * unit(way);
        b.axis = second_.director(side.rod, side.number) * unit(way);
        add(a, b);
    }

    std::size_t table_;
    const JointSpec& spec_;
    Member first_, second_;
    bool same_;
    std::vector<Joint> joints_;
};

} // namespace

double rod_number(const Joint& joint, std::span<const RodGroup> groups, std::int64_t copy) {
    return static_cast<double>(copy * nth(groups, joint.first.group).rods_per_copy() + joint.first.rod);
}

std::vector<std::size_t> joint_memory_of_groups(std::span<const JointSpec> tables, std::span<const Joint> joints,
                                                std::size_t groups) {
    std::map<std::pair<int, std::int64_t>, std::size_t> of_rod;
    for (const Joint& joint : joints)
        if (const std::size_t numbers = memory_numbers(tables[joint.table]); numbers > 0)
            of_rod[{joint.first.group, joint.first.rod}] += numbers;
    std::vector<std::size_t> most(groups, 0);
    for (const auto& [rod, numbers] : of_rod) nth(most, rod.first) = std::max(nth(most, rod.first), numbers);
    return most;
}

JointNumbers numbers_of_joint(std::span<const JointSpec> tables, std::span<const Joint> joints, std::size_t joint) {
    const JointEnd& side = joints[joint].first;
    std::size_t before = 0;
    for (const Joint& earlier : joints.first(joint))
        if (earlier.first.group == side.group && earlier.first.rod == side.rod)
            before += memory_numbers(tables[earlier.table]);
    return {before, memory_numbers(tables[joints[joint].table])};
}

std::vector<Joint> joints_of(std::span<const JointSpec> tables, std::span<const RodGroup> groups, int assembly) {
    std::vector<Joint> joints;
    for (std::size_t t = 0; t < tables.size(); ++t) {
        const auto named = [&](std::size_t i) {
            return std::find_if(groups.begin(), groups.end(),
                                [&](const RodGroup& g) { return g.name() == tables[t].between[i]; });
        };
        const auto first = named(0), second = tables[t].to_world() ? first : named(1);
        if (!first->assembly() || first->assembly()->number != assembly) continue;
        JointMaker maker(t, tables[t], *first, *second);
        const std::vector<Joint> made = tables[t].to_world() ? maker.make_to_world() : maker.make();
        joints.insert(joints.end(), made.begin(), made.end());
    }
    return joints;
}

} // namespace skein
