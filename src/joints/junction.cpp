#include "joints/junction.hpp"

#include "core/rotation.hpp"
#include "rod/end_weights.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace skein {

namespace {

constexpr double same_place = 1e-6; // tolerance over an element's length, as scenes round numbers

Mat3d operator+(const Mat3d& a, const Mat3d& b) { return {a.d1 + b.d1, a.d2 + b.d2, a.d3 + b.d3}; }
Mat3d transposed(const Mat3d& m) {
    return {{m.d1.x, m.d2.x, m.d3.x}, {m.d1.y, m.d2.y, m.d3.y}, {m.d1.z, m.d2.z, m.d3.z}};
}
Mat3d product(const Mat3d& a, const Mat3d& b) {
    const Mat3d columns = transposed(b);
    const auto row = [&](const Vec3d& r) { return Vec3d{dot(r, columns.d1), dot(r, columns.d2), dot(r, columns.d3)}; };
    return {row(a.d1), row(a.d2), row(a.d3)};
}
Mat3d diagonal(const Vec3d& d) { return {{d.x, 0, 0}, {0, d.y, 0}, {0, 0, d.z}}; }
/// The largest row sum bounds the eigenvalues.
double bound(const Mat3d& m) {
    const auto sum = [](const Vec3d& r) { return std::abs(r.x) + std::abs(r.y) + std::abs(r.z); };
    return std::max({sum(m.d1), sum(m.d2), sum(m.d3)});
}

bool holds(const std::vector<long>& list, long number, long count) {
    return std::any_of(list.begin(), list.end(), [&](long i) { return (i < 0 ? count + i : i) == number; });
}

/// One side of a joint: a node of a rod, or a place of a body.
struct Side {
    int group;
    std::int64_t rod;
    int node = 0, element = 0;
    double side = 1;
    bool body = false, inner = false, node_held = false, element_held = false;
    Vec3d arm{0, 0, 0};

    auto key() const { return std::tuple(group, rod, node); }
};

class Builder {
public:
    Builder(std::span<const JointSpec> tables, std::span<const Joint> joints, std::span<const RodGroup> groups)
        : tables_(tables), joints_(joints), groups_(groups) {}

    Junctions build() {
        for (const Joint& joint : joints_) {
            const JointSpec& table = tables_[joint.table];
            if (!shares_node(table)) continue;
            table_ = &table;
            const Side a = side(joint.first), b = side(joint.second);
            if (a.body && b.body)
                refuse("joins two bodies, between which nothing bends: give 'stiffness' [N/m] and "
                       "'torsional_stiffness' [N m/rad]");
            if (a.node_held && b.node_held) refuse(fmt::format("joins two places that are held: leave it out"));
            if (tears(table) && (a.body || b.body || a.inner || b.inner || a.element_held || b.element_held))
                refuse(
                    "tears at a body, an inner node or a held element: 'break_strain' needs two ends that turn freely");
            hub(a, b);
            if (turns_by_half_cells(table)) star(a, b, joint);
            if (tears(table)) tearing_[a.key()] = tearing_[b.key()] = to_index(&joint - joints_.data());
        }
        Junctions all;
        for (std::size_t h = 0; h < hubs_.size(); ++h)
            if (!hubs_[h].sides.empty()) {
                all.hubs.push_back(finished_hub(hubs_[h]));
                all.hubs.back().joint = tearing_joint(hubs_[h]);
            }
        for (std::size_t s = 0; s < stars_.size(); ++s) {
            if (stars_[s].sides.empty()) continue;
            all.stars.push_back(finished_star(stars_[s]));
            all.stars.back().joint = tearing_joint(stars_[s]);
            all.stars.back().break_strain = stars_[s].table->events.break_strain;
            // The rod has the cell around an inner node itself: it is taken off again.
            const std::vector<Side>& sides = stars_[s].sides;
            for (std::size_t i = 0; i + 1 < sides.size(); ++i)
                if (sides[i].inner && sides[i + 1].inner && sides[i].key() == sides[i + 1].key() && sides[i].side > 0)
                    all.stars.push_back(negated(finished_star({{sides[i], sides[i + 1]}, stars_[s].table})));
        }
        return all;
    }

private:
    struct Set {
        std::vector<Side> sides;
        const JointSpec* table;
    };

    /// The joint by which two ends tear from each other.
    std::size_t tearing_joint(const Set& set) {
        for (const Side& s : set.sides) {
            const auto at = tearing_.find(s.key());
            if (at == tearing_.end()) continue;
            table_ = set.table;
            if (set.sides.size() != 2)
                refuse("tears where more than two ends meet: 'break_strain' needs two ends that turn freely");
            return at->second;
        }
        return no_joint;
    }
    [[noreturn]] void refuse(const std::string& what) const {
        throw InputError(fmt::format("{}: the joint between '{}' and '{}' {}", table_->source, table_->between[0],
                                     table_->between[1], what));
    }
    const RodGroup& group(int g) const { return nth(groups_, g); }
    const RodGroup& rod(int g, std::int64_t i) const { return group(g).kind(i); }

    /// Numbers of the springs that come nearest to the missing cell.
    std::string springs(const RodGroup& g, int element) const {
        const ElementConstants& e = nth(g.element, element);
        return fmt::format(
            "stiffness = {:.3g} [N/m] and torsional_stiffness = {:.3g} [N m/rad], which are of first order",
            e.stiffness.z * e.inv_rest_length, std::min(e.bending.x, e.bending.y) * e.inv_rest_length);
    }

    Side side(const JointEnd& end) const {
        const RodGroup& g = rod(end.group, end.rod);
        if (!g.strained()) return {.group = end.group, .rod = end.rod, .node = 0, .body = true, .arm = end.arm};
        const int n = g.elements();
        const bool after = end.share > 0.5;
        refuse_off_nodes(g, end, after);
        Side s{.group = end.group, .rod = end.rod, .node = end.element + (after ? 1 : 0)};
        if (g.closed()) s.node %= n;
        s.inner = g.closed() || (s.node > 0 && s.node < n);
        s.element = s.node == n ? n - 1 : s.node;
        s.side = s.node == n ? -1 : 1;
        if (!s.inner) refuse_end(g, end, s.node);
        s.node_held = g.holds_node(s.node);
        s.element_held = !s.inner && g.holds_element(s.element);
        add_holds(g, end, s);
        return s;
    }

    /// Common nodes are at nodes and on axes.
    void refuse_off_nodes(const RodGroup& g, const JointEnd& end, bool after) const {
        const ElementConstants& e = nth(g.element, end.element);
        if (std::abs(end.share - (after ? 1 : 0)) > same_place) {
            double before = 0, length = 0;
            for (int k = 0; k < g.elements(); ++k) {
                if (k < end.element) before += nth(g.element, k).rest_length;
                length += nth(g.element, k).rest_length;
            }
            refuse(fmt::format("is between two nodes of '{}': with stiffness = \"auto\" 'at' is at a node, here {:.6g} "
                               "or {:.6g}; or give {}",
                               g.name(), before / length, (before + e.rest_length) / length, springs(g, end.element)));
        }
        if (norm(end.arm) > same_place * e.rest_length)
            refuse(fmt::format(
                "has its place {:.3g} m off the axis of '{}': with stiffness = \"auto\" axes meet; or give {}",
                norm(end.arm), g.name(), springs(g, end.element)));
    }

    /// Ends of rods that half cells cannot go on from.
    void refuse_end(const RodGroup& g, const JointEnd& end, int node) const {
        const EndKind kind = node == 0 ? g.spec().start : g.spec().end;
        if (kind == EndKind::clamped)
            refuse(fmt::format("is at an end of '{}' that is clamped: clamp the other rod too", g.name()));
        if (g.slides(node))
            refuse(fmt::format("is at an end of '{}' that slides: give {}", g.name(), springs(g, end.element)));
        if (takes_end_weights(g.spec()))
            refuse(fmt::format("is at an end of '{}' with end_weights = \"gregory\", which are for ends without a "
                               "joint: leave them out",
                               g.name()));
    }

    /// Nodes and elements that the scene holds, in all directions only.
    void add_holds(const RodGroup& g, const JointEnd& end, Side& s) const {
        const Hold& hold = g.spec().hold;
        const int n = g.elements();
        const auto all = [](const std::string& axes) {
            return axes.find('x') != std::string::npos && axes.find('y') != std::string::npos &&
                   axes.find('z') != std::string::npos;
        };
        const auto partly = [&] {
            refuse(fmt::format("is at a place of '{}' that is held in some directions: give {}", g.name(),
                               springs(g, end.element)));
        };
        if (holds(hold.nodes, s.node, g.closed() ? n : n + 1)) {
            if (!all(hold.directions)) partly();
            s.node_held = true;
        }
        const bool before_held = s.inner && holds(hold.elements, (s.node + n - 1) % n, n);
        if (holds(hold.elements, s.element, n) || before_held) {
            if (!all(hold.axes) || s.inner) partly();
            s.element_held = true;
        }
    }

    /// The set that a place is in; a new one where it is in none.
    template <class Key> std::size_t set_of(std::vector<Set>& sets, std::map<Key, std::size_t>& place, const Key& key,
                                            const Side& side) const {
        const auto [at, fresh] = place.try_emplace(key, sets.size());
        if (fresh) sets.push_back({{side}, table_});
        return at->second;
    }
    template <class Key>
    void unite(std::vector<Set>& sets, std::map<Key, std::size_t>& place, std::size_t into, std::size_t from) const {
        if (into == from) return;
        if (into > from) std::swap(into, from);
        for (const Side& s : sets[from].sides) sets[into].sides.push_back(s);
        for (auto& [key, number] : place)
            if (number == from) number = into;
        sets[from].sides.clear();
        if (sets[into].sides.size() > most_members) refuse(fmt::format("makes more than {} ends meet", most_members));
    }

    void hub(const Side& a, const Side& b) {
        const std::size_t of_a = set_of(hubs_, place_of_hub_, a.key(), a),
                          of_b = set_of(hubs_, place_of_hub_, b.key(), b);
        if (a.body || b.body) arm_[(a.body ? b : a).key()] = (a.body ? a : b).arm;
        unite(hubs_, place_of_hub_, of_a, of_b);
    }
    void star(const Side& a, const Side& b, const Joint& joint) {
        using Key = std::tuple<int, std::int64_t, int, std::int64_t>;
        // A body turns as a whole: half cells at each of its joints meet by themselves.
        const auto key = [&](const Side& s) {
            return Key(s.group, s.rod, s.node, s.body ? static_cast<std::int64_t>(&joint - joints_.data()) : -1);
        };
        const auto set = [&](const Side& s) {
            const std::size_t known = stars_.size(), at = set_of(stars_, place_of_star_, key(s), s);
            if (s.inner && at == known) { // both halves of the cell around the node
                Side before = s;
                before.element = (s.node + group(s.group).elements() - 1) % group(s.group).elements();
                before.side = -1;
                stars_.back().sides.push_back(before);
            }
            return at;
        };
        const std::size_t of_a = set(a), of_b = set(b);
        unite(stars_, place_of_star_, of_a, of_b);
    }

    /// The sides of a set, first the one that is a body or held, which the others follow; two such are refused.
    std::vector<Side> with_leader_first(const Set& set, bool Side::*held, const char* fault) {
        table_ = set.table;
        std::vector<Side> sides = set.sides;
        const auto leads = [held](const Side& s) { return s.body || s.*held; };
        if (std::count_if(sides.begin(), sides.end(), leads) > 1)
            refuse(std::string(fault) +
                   ": give 'stiffness' [N/m] and 'torsional_stiffness' [N m/rad] to one of the joints");
        std::stable_sort(sides.begin(), sides.end(), [&](const Side& a, const Side& b) { return leads(a) > leads(b); });
        return sides;
    }

    Hub finished_hub(const Set& set) {
        const std::vector<Side> sides =
            with_leader_first(set, &Side::node_held, "makes one node of places that two bodies or two holds have");
        Hub hub{.members = {}, .body = sides.front().body, .held = sides.front().node_held};
        // Nodes that reach a body through other nodes stand where those do.
        Vec3d arm{0, 0, 0};
        for (const Side& s : sides)
            if (const auto at = arm_.find(s.key()); at != arm_.end()) arm = at->second;
        for (const Side& s : sides) {
            const auto at = arm_.find(s.key());
            hub.members.push_back({s.group, s.rod, s.node,
                                   s.body             ? Vec3d{0, 0, 0}
                                   : at != arm_.end() ? at->second
                                                      : arm});
        }
        return hub;
    }

    Star finished_star(const Set& set) {
        const std::vector<Side> sides =
            with_leader_first(set, &Side::element_held, "makes half cells meet where two bodies or holds are");
        Star star{.members = {}, .rigid = sides.front().body || sides.front().element_held};
        const Quaterniond first = start_frame(sides.front());
        Mat3d sum{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
        double lengths = 0;
        bool one_law = true;
        star.along_axes = true;
        for (std::size_t i = 0; i < sides.size(); ++i) {
            const Side& s = sides[i];
            const RodGroup& g = rod(s.group, s.rod);
            Star::Member m{.group = s.group, .rod = s.rod, .element = s.element, .side = s.inner ? 0 : s.side};
            m.rest = i == 0 ? no_turn : start_frame(s) * inverse(first);
            m.turn = matrix(m.rest);
            m.rest_stretch = 1;
            if (!(i == 0 && star.rigid)) {
                const ElementConstants& e = nth(g.element, s.element);
                m.length = e.rest_length;
                m.rest_stretch = e.rest_stretch;
                const double half = 0.5 * e.rest_length;
                m.compliance = {half / e.bending.x, half / e.bending.y, half / e.bending.z};
                m.stiffness = {1 / m.compliance.x, 1 / m.compliance.y, 1 / m.compliance.z};
                m.rest_turn = (s.side * half) * curvature_since_start(g, s);
                m.to_frame = product(transposed(m.turn), diagonal(m.stiffness));
                sum = sum + product(m.to_frame, m.turn);
                const Law law = g.law() == Law::elastica ? Law::incompressible : g.law();
                if (lengths == 0) star.law = law;
                one_law = one_law && star.law == law;
                lengths += m.length;
                star.along_axes = star.along_axes && std::abs(std::abs(m.turn.d3.z) - 1) < 1e-12;
            }
            star.members.push_back(m);
        }
        if (!one_law) star.law = Law::linear;
        star.inv_cell = 2 / lengths;
        const Mat3d frame = inverse(sum);
        for (Star::Member& m : star.members) {
            m.share = m.length / lengths;
            m.to_frame = star.rigid ? diagonal({0, 0, 0}) : product(frame, m.to_frame);
            if (!star.rigid ||
                m.length > 0) { // against the frame, of the others' inertia as good as rigid: no more than its own
                const Mat3d in_frame = product(product(transposed(m.turn), diagonal(m.stiffness)), m.turn);
                if (star.rigid) star.largest = std::max(star.largest, bound(in_frame));
                else
                    star.largest =
                        std::max(star.largest, bound(product(in_frame, product(frame, sum + scaled(in_frame, -1)))));
            }
        }
        return star;
    }
    static Star negated(Star star) {
        for (Star::Member& m : star.members) {
            m.stiffness = -1.0 * m.stiffness;
            m.compliance = -1.0 * m.compliance;
        }
        star.largest = 0;
        return star;
    }
    static Mat3d scaled(const Mat3d& m, double by) { return {by * m.d1, by * m.d2, by * m.d3}; }

    Quaterniond start_frame(const Side& s) const {
        const RodGroup& g = rod(s.group, s.rod);
        std::vector<Slot<1>> state(to_index(g.slots()));
        g.start_state_in_assembly(s.rod, state);
        const auto at = [&](int k) { return lane(nth(state, k).director, 0); };
        return at(s.element);
    }

    /// By how much the rest curvature of the nearest cell differs from its curvature at the start, 1/m.
    static Vec3d curvature_since_start(const RodGroup& g, const Side& s) {
        if (g.voronoi.empty()) return g.spec().shape.rest_curvature;
        const std::size_t cell = s.inner      ? to_index((s.node + g.elements() - 1) % g.elements())
                                 : s.side > 0 ? 0
                                              : g.voronoi.size() - 1;
        const auto frames = g.start_directors();
        const Vec3d turned = relative_rotation(frames[(cell + 1) % frames.size()], frames[cell]);
        return g.voronoi[cell].rest_curvature - g.voronoi[cell].inv_length * turned;
    }

    std::span<const JointSpec> tables_;
    std::span<const Joint> joints_;
    std::span<const RodGroup> groups_;
    const JointSpec* table_ = nullptr;
    std::vector<Set> hubs_, stars_;
    std::map<std::tuple<int, std::int64_t, int>, std::size_t> place_of_hub_;
    std::map<std::tuple<int, std::int64_t, int, std::int64_t>, std::size_t> place_of_star_;
    std::map<std::tuple<int, std::int64_t, int>, Vec3d> arm_;           ///< arms of nodes on bodies, m
    std::map<std::tuple<int, std::int64_t, int>, std::size_t> tearing_; ///< joints that tear, by the places of both
};

} // namespace

Junctions junctions_of(std::span<const JointSpec> tables, std::span<const Joint> joints,
                       std::span<const RodGroup> groups) {
    return Builder(tables, joints, groups).build();
}

} // namespace skein
