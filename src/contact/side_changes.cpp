// Elements that change sides within a step, which contact forces are to prevent.                 theory.md (58c)
//   motion of a step   from x - h v to x, as rates have brought bodies there
//   rods               the vector between nearest points turns round, and axes cross: both points inside before and
//                      after, or axes nearer than half the sum of radii on the way
//   boxes              intersect without their rounding
//   balls              axes come nearer than half the sum of radii; near-parallel rods pass like discs, at an eighth
// A pair that moves relatively by less than 0.4 of its radii ends such a step nearer than half: find_touching() lists
// it at no cost. Elements that move farther are searched only where they may be. The list of candidates has all that
// they touch on the way while it holds; a search finds the rest. Bodies that begin so deep in each other, or whose law
// is still soft, have no sides. They are watched once they have come apart.
#include "contact/box_pair.hpp"
#include "contact/contact_limits.hpp"
#include "contact/work_area.hpp"
#include "core/closest_points.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace skein {

namespace {

/// Two elements on their way: where it began, and how far their ends go.
struct Passing {
    Vec3d at[4], way[4]; ///< start and end of the first, of the second

    struct Near {
        Vec3d apart;
        double distance, sine_squared;
        bool inside; ///< both nearest points are
    };
    Near near(double share) const {
        Vec3d x[4];
        for (int i = 0; i < 4; ++i) x[i] = at[i] + share * way[i];
        const auto found = closest_points(broadcast<1>(x[0]), broadcast<1>(x[1] - x[0]), broadcast<1>(x[2]),
                                          broadcast<1>(x[3] - x[2]));
        const auto within = [](double s) { return s > 0 && s < 1; };
        const Vec3d apart = lane(found.apart, 0);
        return {apart, norm(apart), found.sine_squared[0], within(found.s[0]) && within(found.t[0])};
    }
    bool is_point(int first, double tiny) const { return norm(at[first + 1] - at[first]) < tiny; }
    /// The longest way of a point of one against a point of the other.
    double relative() const {
        double most = 0;
        for (const int i : {0, 1})
            for (const int k : {2, 3}) most = std::max(most, norm(way[i] - way[k]));
        return most;
    }
    /// The first distance on the way that is not above `limit`, or that at its end. Distances change no faster than the
    /// longest relative way, so what is farther off by some way is not reached before. A way of a run that blows up is
    /// seen in 10 000 parts.
    double first_below(double limit) const {
        const double whole = relative();
        double distance = near(0).distance;
        for (double share = 0; distance > limit && share < 1 && std::isfinite(whole); distance = near(share).distance)
            share = std::min(1.0, share + std::max({(distance - limit) / whole, 0.01 * limit / whole, 1e-4}));
        return distance;
    }
};

constexpr double half = 0.5, eighth = 0.125; ///< shares of the sum of radii
/// Share of the sum of radii: where neither of two moves so far, what passes within 0.45 of it ends nearer than half of
/// it.
constexpr double far = 0.2;

} // namespace

Contacts::BodyPair Contacts::bodies_of(const SceneSlots& scene, std::int64_t a, std::int64_t b) {
    const std::int64_t first = scene.gid_at(a), second = scene.gid_at(b);
    return {std::min(first, second), std::max(first, second)};
}

bool Contacts::is_overlapping(const BodyPair& bodies) const {
    return !overlapping_.empty() && std::binary_search(overlapping_.begin(), overlapping_.end(), bodies);
}

void Contacts::update_overlapping() {
    if (!watches_) return;
    begins_ = false;
    std::sort(overlap_now_.begin(), overlap_now_.end());
    overlap_now_.erase(std::unique(overlap_now_.begin(), overlap_now_.end()), overlap_now_.end());
    std::swap(overlapping_, overlap_now_);
}

/// Restores the bodies whose saved contacts say that they began so.
void Contacts::restore_overlapping(const Exposure& bodies) {
    for (const SavedContact& kept : saved_)
        if (kept.status & began_deep) overlapping_.push_back(bodies_of(bodies.scene(), kept.a, kept.b));
    std::sort(overlapping_.begin(), overlapping_.end());
}

std::optional<SideChange> Contacts::side_change(const Exposure& bodies, Pair pair) {
    const auto [a, b] = pair;
    if (box_at(bodies, a) && box_at(bodies, b)) return boxes_intersect(bodies, pair);
    if (box_at(bodies, a) || box_at(bodies, b)) return {};
    const auto group_a = to_index(bodies.at(a).group), group_b = to_index(bodies.at(b).group);
    const ContactLaw& law = laws_.between(group_a, group_b);
    Passing passing;
    const std::uint32_t slots[] = {a, a + 1, b, b + 1};
    for (int i = 0; i < 4; ++i) {
        passing.way[i] = drift_ * bodies.motion[slots[i]].velocity;
        passing.at[i] = bodies.node[slots[i]].position - passing.way[i];
    }
    const double reach = bodies.node[a].radius + bodies.node[b].radius, way = passing.relative();
    const Passing::Near before = passing.near(0), after = passing.near(1);
    const bool deep = after.distance < half * reach;
    if (!(before.distance + after.distance <= reach + way) && !deep) return {};
    const BodyPair gids = bodies_of(bodies.scene(), bodies.in_scene(a), bodies.in_scene(b));
    if (time_ < law.soft_until || (begins_ && before.distance < half * reach) || is_overlapping(gids)) {
        if (!deep) return {};
        const std::lock_guard lock(noting_);
        overlap_now_.push_back(gids);
        return {};
    }
    const bool balls = passing.is_point(0, 1e-9 * reach) || passing.is_point(2, 1e-9 * reach),
               parallel = before.sine_squared < blend * blend && after.sine_squared < blend * blend;
    const double limit = (balls || !parallel ? half : eighth) * reach;
    const bool turned = dot(before.apart, after.apart) <= 0; // 0: they meet where the step begins or ends
    double nearest = after.distance / reach;
    if (turned && before.inside && after.inside) nearest = 0;
    else if (turned || ((balls || parallel) && !(before.distance < limit))) {
        const double least = passing.first_below(limit);
        if (!(least <= limit)) return {};
        nearest = least / reach;
    } else return {};
    const double speed = way / drift_, overlap = std::max(0.0, reach - before.distance),
                 mass = 1 / (1 / scene_.mass_of(bodies.at(a)) + 1 / scene_.mass_of(bodies.at(b)));
    return SideChange{pair, nearest, speed, half * mass * speed * speed + energy_at(law.at(time_), overlap),
                      2 * std::min(bodies.node[a].radius, bodies.node[b].radius)};
}

/// Boxes whose sharp cores intersect, unless they began so.
std::optional<SideChange> Contacts::boxes_intersect(const Exposure& bodies, Pair pair) {
    const auto [a, b] = pair;
    const PartBox &one = *box_at(bodies, a), &two = *box_at(bodies, b);
    const Vec3d& origin = bodies.node[a].position;
    if (!(separation(placed_box(bodies, a, one, origin), placed_box(bodies, b, two, origin), true) < 0)) return {};
    const auto group_a = to_index(bodies.at(a).group), group_b = to_index(bodies.at(b).group);
    const ContactLaw& law = laws_.between(group_a, group_b);
    const BodyPair gids = bodies_of(bodies.scene(), bodies.in_scene(a), bodies.in_scene(b));
    if (time_ < law.soft_until || begins_ || is_overlapping(gids)) {
        const std::lock_guard lock(noting_);
        overlap_now_.push_back(gids);
        return {};
    }
    const ExposedMotion &at_a = bodies.motion[a], &at_b = bodies.motion[b];
    const double speed = norm(at_a.velocity - at_b.velocity) + norm(at_a.spin) * norm(one.half) +
                         norm(at_b.spin) * norm(two.half),
                 mass = 1 / (1 / scene_.mass_of(bodies.at(a)) + 1 / scene_.mass_of(bodies.at(b)));
    return SideChange{pair, 0, speed, half * mass * speed * speed + energy_at(law.at(time_), one.radius + two.radius),
                      2 * std::min(one.radius, two.radius)};
}

void Contacts::check_side_changes(const Exposure& bodies, std::span<const std::uint32_t> pairs) {
    for (const std::uint32_t pair : pairs)
        if (const auto change = side_change(bodies, list_.pair[pair])) {
            const std::lock_guard lock(noting_);
            side_changes_.push_back(*change);
        }
}

/// True where an own element has moved so far in this step that it may have passed another unseen.
bool Contacts::moves_far(const Exposure& bodies, std::size_t slot) const {
    if (!bodies.has_element(slot)) return false;
    const Vec3d &one = bodies.motion[slot].velocity, &other = bodies.motion[slot + 1].velocity;
    const double way = drift_ * std::sqrt(std::max(dot(one, one), dot(other, other)));
    return way >= far * (bodies.node[slot].radius + scene_.thinnest);
}

double Contacts::largest_displacement(const Exposure& bodies) {
    far_in_scene_.clear();
    double most = 0;
    for (const Window& w : bodies.window) {
        if (!w.own) continue;
        for (std::uint32_t slot = w.first_slot; slot + 1 < w.first_slot + w.slots; ++slot) {
            if (!moves_far(bodies, slot)) continue;
            far_in_scene_.push_back(bodies.in_scene(slot));
            for (const std::uint32_t end : {slot, slot + 1})
                if (const double way = drift_ * norm(bodies.motion[end].velocity); std::isfinite(way))
                    most = std::max(most, way);
        }
    }
    return most;
}

/// Marks elements that have moved far, where some may have.
void Contacts::mark_far_moves(const Exposure& bodies) {
    watches_ = drift_ > 0;
    far_.clear();
    if (!watches_ || displacement_ < 2 * far * scene_.thinnest || !passed_.empty()) return;
    far_.resize(bodies.slots());
    std::atomic<bool> some = false;
    for_blocks(threads_, far_.size(), [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t slot = begin; slot < end; ++slot) {
            far_[slot] = bodies.has_element(slot) && bodies.owns_slot(slot) && moves_far(bodies, slot);
            if (far_[slot] != 0) some.store(true, std::memory_order_relaxed);
        }
    });
    if (!some) far_.clear();
}

/// Pairs that are no candidates, of which one has moved far and may have passed the other.
void Contacts::find_passed(const Exposure& near, std::span<std::uint8_t> wanted) {
    struct Element {
        double x;
        std::uint32_t slot;
    };
    std::vector<Element> elements;
    const auto middle = [&](std::uint32_t slot) {
        return 0.5 * (near.node[slot].position + near.node[slot + 1].position);
    };
    const auto reach = [&](std::uint32_t slot) {
        return 0.5 * norm(near.node[slot + 1].position - near.node[slot].position) + near.node[slot].radius;
    };
    double largest = 0;
    for (std::uint32_t slot = 0; slot < near.slots(); ++slot) {
        if (!near.has_element(slot)) continue;
        elements.push_back({middle(slot).x, slot});
        largest = std::max(largest, reach(slot));
    }
    std::sort(elements.begin(), elements.end(), [](const Element& x, const Element& y) { return x.x < y.x; });
    for (const std::int64_t in_scene : far_in_scene_) {
        const auto slot = near.find(in_scene);
        if (!slot) continue;
        const Vec3d here = middle(*slot);
        const double own = reach(*slot) + 2 * largest_displacement_, window = own + largest;
        auto other = std::lower_bound(elements.begin(), elements.end(), here.x - window,
                                      [](const Element& e, double x) { return e.x < x; });
        for (; other != elements.end() && other->x <= here.x + window; ++other) {
            const std::uint32_t low = std::min(*slot, other->slot), high = std::max(*slot, other->slot);
            const Vec3d apart = middle(other->slot) - here;
            const double within = own + reach(other->slot);
            if (low == high || !(dot(apart, apart) <= within * within) || !may_touch(near, scene_.rules, low, high))
                continue;
            passed_.push_back({near.in_scene(low), near.in_scene(high)});
            for (const std::uint32_t one : {low, high})
                if (!near.owns_slot(one)) near.with_neighbours(one, [&](std::uint32_t ghost) { wanted[ghost] = 1; });
        }
    }
    std::sort(passed_.begin(), passed_.end());
    passed_.erase(std::unique(passed_.begin(), passed_.end()), passed_.end());
}

/// Checks all pairs with an element that has moved far.
void Contacts::check_far_moves(const Exposure& bodies) {
    const auto note = [&](Pair pair) {
        if (const auto change = side_change(bodies, pair);
            change && std::find(side_changes_.begin(), side_changes_.end(), *change) == side_changes_.end())
            side_changes_.push_back(*change);
    };
    for (std::uint32_t i = 0; !far_.empty() && i < list_.count(); ++i)
        if (const auto [a, b] = list_.pair[i]; far_[a] | far_[b]) note({a, b});
    for (const auto& [first, second] : passed_)
        if (const auto a = bodies.find(first), b = bodies.find(second); a && b) note({*a, *b});
    passed_.clear();
}

} // namespace skein
