#include "constraints.hpp"

#include "core/rotation.hpp"
#include "skein/core/index.hpp"

#include <numbers>

namespace skein::replay {

namespace {

struct HeldNode {
    std::size_t at;
    Vec3d position;
};
struct HeldElement {
    std::size_t at;
    Quaterniond director;
};

std::vector<HeldNode> held_nodes(const std::vector<int>& at, std::span<const Slot<1>> start) {
    std::vector<HeldNode> held;
    for (const int i : at) held.push_back({static_cast<std::size_t>(i), lane(nth(start, i).position, 0)});
    return held;
}
std::vector<HeldElement> held_elements(const std::vector<int>& at, std::span<const Slot<1>> start) {
    std::vector<HeldElement> held;
    for (const int k : at) held.push_back({static_cast<std::size_t>(k), lane(nth(start, k).director, 0)});
    return held;
}

/// Nodes and elements back where they started, at rest.
class Fixed final : public Constraint {
public:
    Fixed(std::vector<HeldNode> nodes, std::vector<HeldElement> elements)
        : nodes_(std::move(nodes)), elements_(std::move(elements)) {}
    void values(Slot<1>* slot, double) const override {
        for (const auto& [i, x] : nodes_) slot[i].position = broadcast<1>(x);
        for (const auto& [k, q] : elements_) slot[k].director = broadcast<1>(q);
    }
    void rates(Slot<1>* slot, double) const override {
        for (const auto& held : nodes_) slot[held.at].velocity = {};
        for (const auto& held : elements_) slot[held.at].spin = {};
    }

private:
    std::vector<HeldNode> nodes_;
    std::vector<HeldElement> elements_;
};

/// Chosen lab components: of positions (held at their start) and of angular velocities (frames drift).
class General final : public Constraint {
public:
    General(std::vector<HeldNode> nodes, std::vector<HeldElement> elements, const Vec3d& translation,
            const Vec3d& rotation)
        : nodes_(std::move(nodes)), elements_(std::move(elements)), held_(translation), free_(free_of(translation)),
          free_turns_(free_of(rotation)) {}
    void values(Slot<1>* slot, double) const override {
        for (const auto& [i, x] : nodes_)
            slot[i].position = broadcast<1>(scale(free_, lane(slot[i].position, 0)) + scale(held_, x));
    }
    void rates(Slot<1>* slot, double) const override {
        for (const auto& held : nodes_) slot[held.at].velocity = scale(broadcast<1>(free_), slot[held.at].velocity);
        for (const auto& held : elements_) {
            Slot<1>& s = slot[held.at];
            s.spin = s.director * scale(broadcast<1>(free_turns_), transpose_times(s.director, s.spin));
        }
    }

private:
    static Vec3d free_of(const Vec3d& held) { return {1 - held.x, 1 - held.y, 1 - held.z}; }
    std::vector<HeldNode> nodes_;
    std::vector<HeldElement> elements_;
    Vec3d held_, free_, free_turns_;
};

/// Ends that approach by `slack` and turn against each other until `twisting_time`, then stand. The angular velocity
/// has the lab components of the line between the ends, taken as body components without transformation: as published.
class HelicalBuckling final : public Constraint {
public:
    HelicalBuckling(std::span<const Slot<1>> start, std::size_t last_node, std::size_t last_element, double time,
                    double slack, double rotations)
        : time_(time), last_(last_node), last_element_(last_element) {
        const Vec3d first = lane(start.front().position, 0), end = lane(start[last_].position, 0);
        const Vec3d d = (1 / norm(end - first)) * (end - first);
        const double angle = rotations * std::numbers::pi;
        velocity_ = slack / (2 * time) * d;
        spin_ = angle / time * d;
        first_ = first + 0.5 * slack * d;
        end_ = end - 0.5 * slack * d;
        first_director_ = rotation(angle * d) * lane(start.front().director, 0);
        end_director_ = rotation(-angle * d) * lane(start[last_element_].director, 0);
    }
    void values(Slot<1>* slot, double t) const override {
        if (t <= time_) return;
        slot[0].position = broadcast<1>(first_);
        slot[last_].position = broadcast<1>(end_);
        slot[0].director = broadcast<1>(first_director_);
        slot[last_element_].director = broadcast<1>(end_director_);
    }
    void rates(Slot<1>* slot, double t) const override {
        const double moving = t <= time_;
        slot[0].velocity = broadcast<1>(moving * velocity_);
        slot[last_].velocity = broadcast<1>(-moving * velocity_);
        slot[0].spin = broadcast<1>(moving * spin_);
        slot[last_element_].spin = broadcast<1>(-moving * spin_);
    }

private:
    double time_;
    std::size_t last_, last_element_;
    Vec3d velocity_, spin_, first_, end_;
    Quaterniond first_director_, end_director_;
};

std::vector<int> places(const Entry& e, const std::string& key, std::size_t size) {
    std::vector<int> at;
    if (e.has(key))
        for (const Entry& i : e[key].list()) at.push_back(i.index(static_cast<int>(size)));
    return at;
}

} // namespace

std::shared_ptr<const Constraint> make_constraint(const Entry& e, std::span<const Slot<1>> start,
                                                  std::size_t node_count, std::size_t element_count) {
    const std::string kind = e["kind"].text();
    if (kind == "one_end_fixed") return std::make_shared<Fixed>(held_nodes({0}, start), held_elements({0}, start));
    if (kind == "helical_buckling" && node_count > 1)
        return std::make_shared<HelicalBuckling>(start, node_count - 1, element_count - 1,
                                                 e["twisting_time"].positive(), e["slack"].number(),
                                                 e["number_of_rotations"].number());
    if (kind != "fixed" && kind != "general") throw NotBuilt("constraint '" + kind + "' (" + e.path() + ")");
    auto nodes = held_nodes(places(e, "position_index", node_count), start);
    auto elements = held_elements(places(e, "director_index", element_count), start);
    if (kind == "fixed") return std::make_shared<Fixed>(std::move(nodes), std::move(elements));
    return std::make_shared<General>(std::move(nodes), std::move(elements), e["translation_fixed"].flags(),
                                     e["rotation_fixed_lab"].flags());
}

} // namespace skein::replay
