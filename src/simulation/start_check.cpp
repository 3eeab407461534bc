#include "simulation/start_check.hpp"

#include "contact/box_pair.hpp"
#include "contact/contact_solver.hpp"
#include "contact/segment_meeting.hpp"
#include "core/closest_points.hpp"
#include "kernels/kernels.hpp"
#include "mechanics/rod_copies.hpp"
#include "physics/contact/contact_plan.hpp"
#include "physics/fluid/fluid_plan.hpp"
#include "physics/walls/wall_plan.hpp"
#include "rod/body_name.hpp"
#include "rod/body_shape.hpp"
#include "skein/core/error.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace skein {

namespace {

std::vector<Slot<1>> start_of(const RodGroup& group, const LocalRod& body) {
    std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
    group.start_state(body.index, state);
    return state;
}

void show_all(std::span<const RodGroup> groups, std::span<const LocalRod> bodies, Exposure& exposure) {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        const RodGroup& group = nth(groups, bodies[i].group);
        exposure.show(i, start_of(group, bodies[i]), group.body());
    }
}

/// The deepest pair of elements, by slots of the scene, over the smaller diameter.
struct Deepest {
    double overlap = 0;
    std::int64_t first = std::numeric_limits<std::int64_t>::max(), second = first;
    void take(double share, std::int64_t a, std::int64_t b) {
        if (share > overlap || (share == overlap && std::tie(a, b) < std::tie(first, second))) {
            overlap = share;
            first = a;
            second = b;
        }
    }
};

class PairsAtStart {
public:
    PairsAtStart(const ContactPlan& plan, std::span<const RodGroup> groups, const Exposure& near, const Exposure& own)
        : plan_(plan), groups_(groups), near_(near), own_(own) {}

    /// Shares the axes of own boxes that are in pairs with boxes. Collective; `comm`: null where this process is alone.
    void share_axes(const Candidates& found, const Communicator* comm) {
        constexpr std::size_t record = 7;
        std::vector<double> mine;
        const auto add = [&](std::uint32_t slot) {
            const auto own = near_.owns_slot(slot) ? own_.find(near_.in_scene(slot)) : std::optional<std::uint32_t>();
            if (!own) return;
            const Vec3d &first = own_.motion[*own + 1].velocity, &second = own_.motion[*own + 1].spin;
            for (const double number :
                 {static_cast<double>(near_.in_scene(slot)), first.x, first.y, first.z, second.x, second.y, second.z})
                mine.push_back(number);
        };
        for (std::uint32_t a = 0; a + 1 < found.first.size(); ++a)
            for (std::uint32_t i = found.first[a]; i < found.first[a + 1]; ++i)
                if (const std::uint32_t b = found.partner[i]; box(a) && box(b))
                    for (const std::uint32_t slot : {a, b}) add(slot);
        const std::vector<double> all = comm ? comm->all_gather(mine) : mine;
        for (std::size_t i = 0; i < all.size(); i += record)
            axes_[static_cast<std::int64_t>(all[i])] = {Vec3d{all[i + 1], all[i + 2], all[i + 3]},
                                                        Vec3d{all[i + 4], all[i + 5], all[i + 6]}};
    }
    Deepest deepest(const Candidates& found) const {
        Deepest deepest;
        for (std::uint32_t a = 0; a + 1 < found.first.size(); ++a)
            for (std::uint32_t i = found.first[a]; i < found.first[a + 1]; ++i) {
                const std::uint32_t b = found.partner[i];
                if (plan_.laws.between(group(a), group(b)).soft_until > 0) continue;
                const double diameter = 2 * std::min(radius(a), radius(b)),
                             share = (radius(a) + radius(b) - distance(a, b)) / diameter;
                if (share > plan_.spec.overlap) deepest.take(share, near_.in_scene(a), near_.in_scene(b));
            }
        return deepest;
    }

private:
    std::size_t group(std::uint32_t slot) const { return static_cast<std::size_t>(near_.at(slot).group); }
    const BodyShape::Part* box(std::uint32_t slot) const {
        const BodyShape* body = groups_[group(slot)].body();
        if (!body) return nullptr;
        const BodyShape::Part& part = body->part[static_cast<std::size_t>(near_.element(slot)) / 2];
        return part.box ? &part : nullptr;
    }
    double radius(std::uint32_t slot) const {
        const BodyShape::Part* part = box(slot);
        return part ? part->radius : near_.node[slot].radius;
    }
    double distance(std::uint32_t a, std::uint32_t b) const {
        const auto at = [&](std::uint32_t slot) { return near_.node[slot].position; };
        if (box(a) && box(b)) {
            const bool known = axes_.contains(near_.in_scene(a)) && axes_.contains(near_.in_scene(b));
            return known ? distance_of_boxes(placed(a), placed(b), radius(a) + radius(b)) : HUGE_VAL;
        }
        if (box(a) || box(b)) return box(a) ? distance_to_box(a, b) : distance_to_box(b, a);
        const auto found = closest_points(broadcast<1>(at(a)), broadcast<1>(at(a + 1) - at(a)), broadcast<1>(at(b)),
                                          broadcast<1>(at(b + 1) - at(b)));
        return norm(lane(found.apart, 0));
    }
    /// A box of a pair of two; its axes are known once they are shared.
    PlacedBox placed(std::uint32_t slot) const {
        const auto& [first, second] = axes_.at(near_.in_scene(slot));
        return {near_.node[slot].position, {first, second, cross(first, second)}, box(slot)->half};
    }
    /// Below 0 where sharp boxes intersect. `reach`, where they are farther apart.
    static double distance_of_boxes(const PlacedBox& one, const PlacedBox& two, double reach) {
        const double apart = separation(one, two, true);
        return apart < 0 ? apart : reach - BoxMeeting(one, two, reach).deepest();
    }
    /// Distance of an element and the box of an own body, which has its axes here; other ranks test their own boxes.
    double distance_to_box(std::uint32_t slot, std::uint32_t element) const {
        const auto own = near_.owns_slot(slot) ? own_.find(near_.in_scene(slot)) : std::optional<std::uint32_t>();
        if (!own) return HUGE_VAL;
        const ExposedMotion& shown = own_.motion[*own + 1];
        const Mat3d axes{shown.velocity, shown.spin, cross(shown.velocity, shown.spin)};
        const Vec3d &from = near_.node[element].position, &to = near_.node[element + 1].position;
        const double reach = radius(slot) + radius(element);
        const SegmentMeeting meeting({axes * (from - near_.node[slot].position), axes * (to - from), {1, 1}},
                                     box(slot)->half, reach, ContactNormal::linear);
        return reach - meeting.deepest();
    }

    const ContactPlan& plan_;
    std::span<const RodGroup> groups_;
    const Exposure &near_, &own_;
    std::map<std::int64_t, std::pair<Vec3d, Vec3d>> axes_; ///< first two of boxes, by slot of the scene
};

/// "rod 3 of 'cilia' (element 4)" of a slot of the scene.
std::string place_in_scene(const SceneSlots& scene, std::span<const RodGroup> groups, std::int64_t slot) {
    const std::int64_t gid = scene.gid_at(slot), k = slot - scene.first_slot(gid);
    const bool strained = nth(groups, scene.group_of(gid)).strained();
    return fmt::format("{} ({} {})", name_of_body(groups, gid), strained ? "element" : "part", strained ? k : k / 2);
}

/// Depth of a ball in a wall that has moved from its place, m.
double depth_in(const Wall& wall, const Vec3d& moved, const Vec3d& place, double radius) {
    const double width = wall.touches == WallTouch::axis ? 0 : radius;
    const Vec3d from = place - (wall.point + moved);
    if (wall.kind == WallKind::plane) return width - dot(wall.normal, from);
    const double away = wall.kind == WallKind::tube ? norm(from - dot(from, wall.axis) * wall.axis) : norm(from);
    return wall.side == WallSide::inside ? away + width - wall.radius : wall.radius + width - away;
}

bool in_obstacle(const Obstacle& obstacle, const Vec3d& place) {
    return obstacle.shape()->distance(obstacle.axes_at(0) * (place - obstacle.place_at(0))) < 0;
}

constexpr double allowed_in_walls = ContactSpec{}.overlap; ///< of the diameter

/// True where a wall that stands takes bodies of the group from a time on, s, no deeper than is allowed.
bool refuses_depth(const Wall& wall, const RodGroup& group, double time) {
    return wall.stands && wall.acts_on(group.name()) && !wall.allow_overlap && wall.law.soft_until <= time;
}

/// Fault of the place of a ball: a free node, or a point of a body's surface; empty: none.
std::string fault_of_place(const Plan& plan, const RodGroup& group, const std::string& what, const Vec3d& place,
                           double radius) {
    const auto* walls = plan.find<WallPlan>();
    for (const Wall& wall : walls ? std::span<const Wall>(walls->walls) : std::span<const Wall>()) {
        if (!refuses_depth(wall, group, 0)) continue;
        if (const double share = depth_in(wall, {0, 0, 0}, place, radius) / (2 * radius); share > allowed_in_walls)
            return fmt::format(
                "{}: {} is {:.3g} of its diameter deep in the wall '{}' at the start, and {:g} is allowed: move it, or "
                "let it start there with allow_overlap = true in that [[wall]]",
                wall.source, what, share, wall.name, allowed_in_walls);
    }
    const auto* fluid = plan.find<FluidPlan>();
    if (!fluid) return {};
    for (const Obstacle& obstacle : fluid->obstacles)
        if (in_obstacle(obstacle, place))
            return fmt::format("{}: {} is within the obstacle '{}' at the start: move one of them", obstacle.source,
                               what, obstacle.name);
    const FluidGrid& grid = fluid->constants.grid;
    const Vec3d nearest{std::clamp(place.x, grid.lower.x, grid.upper().x),
                        std::clamp(place.y, grid.lower.y, grid.upper().y),
                        std::clamp(place.z, grid.lower.z, grid.upper().z)};
    for (int d = 0; d < 3; ++d)
        if (const double beyond = std::abs(component_of(place - nearest, d)); !grid.periodic(d) && beyond > radius)
            return fmt::format(
                "{}: {} is {:.3g} m outside the box of the fluid along {} at the start: move it, or make the box "
                "larger, or that direction periodic",
                group.spec().source, what, beyond, "xyz"[d]);
    return {};
}

/// A body, by its number in the scene, and its fault; empty: none.
using FaultOfBody = std::pair<std::int64_t, std::string>;

/// The first body of this rank that stands where it cannot. `state_of(group, number of the body here)`;
/// `fault_of(group, name, place, radius)` of a ball.
template <class StateOf, class FaultOf> FaultOfBody first_fault(std::span<const RodGroup> groups,
                                                                std::span<const LocalRod> bodies, StateOf&& state_of,
                                                                FaultOf&& fault_of) {
    FaultOfBody first{std::numeric_limits<std::int64_t>::max(), ""};
    for (std::size_t number = 0; number < bodies.size(); ++number) {
        const LocalRod& body = bodies[number];
        if (body.gid >= first.first) continue;
        const RodGroup& group = nth(groups, body.group);
        std::string fault;
        const auto look = [&](const char* part, std::size_t i, const Vec3d& place, double radius) {
            if (!fault.empty()) return;
            const std::string what = fmt::format("{} ({} {})", name_of_body(groups, body.gid), part, i);
            fault = fault_of(group, what, place, radius);
        };
        if (const BodyShape* shape = group.body()) {
            const std::vector<Slot<1>> state = state_of(group, number);
            for (std::size_t i = 0; i < shape->point.size(); ++i)
                look("point", i,
                     lane(state[0].position + transpose_times(state[0].director, broadcast<1>(shape->point[i].place)),
                          0),
                     shape->point[i].radius);
        } else {
            with_rod(group, body.index, [&](const RodGroup& own) {
                const std::vector<Slot<1>> state = state_of(own, number);
                for (std::size_t i = 0; i < state.size(); ++i)
                    if (!own.holds_node(static_cast<int>(i)) && !own.slides(static_cast<int>(i)))
                        look("node", i, lane(state[i].position, 0), node_radius(own, static_cast<std::int64_t>(i)));
            });
        }
        if (!fault.empty()) first = {body.gid, fault};
    }
    return first;
}

FaultOfBody fault_of_places(const Plan& plan, std::span<const RodGroup> groups, std::span<const LocalRod> bodies) {
    if (!plan.has<WallPlan>() && !plan.has<FluidPlan>()) return {std::numeric_limits<std::int64_t>::max(), ""};
    return first_fault(
        groups, bodies, [&](const RodGroup& group, std::size_t i) { return start_of(group, bodies[i]); },
        [&](const RodGroup& group, const std::string& what, const Vec3d& place, double radius) {
            return fault_of_place(plan, group, what, place, radius);
        });
}

/// `comm`: null where this process is alone, which may be without MPI.
void refuse(const Communicator* comm, const Threads& threads, const Plan& plan, std::span<const RodGroup> groups,
            std::span<const LocalRod> bodies, Exposure* exposure, Neighbourhood* neighbourhood) {
    const auto [gid, fault] = fault_of_places(plan, groups, bodies);
    const auto least_of_all = [&](std::int64_t x) { return comm ? comm->min(x) : x; };
    const std::string mine_first = gid == least_of_all(gid) ? fault : std::string();
    if (const std::string text = comm ? comm->first_text(mine_first) : mine_first; !text.empty())
        throw InputError(text);
    const auto* contact = plan.find<ContactPlan>();
    if (!exposure || !contact || contact->spec.allow_overlap) return;
    show_all(groups, bodies, *exposure);
    const auto solver = kernels(plan.machine.lanes).make_contacts(contact->scene(groups), threads);
    const Exposure& near = neighbourhood ? neighbourhood->widen(solver->next_skin()) : *exposure;
    std::vector<std::uint8_t> wanted(near.slots(), 0);
    solver->search(near, wanted);
    PairsAtStart pairs(*contact, groups, near, *exposure);
    pairs.share_axes(solver->found(), comm);
    const Deepest mine = pairs.deepest(solver->found());
    if (neighbourhood) {
        std::fill(wanted.begin(), wanted.end(), std::uint8_t{0});
        neighbourhood->narrow(wanted);
    }
    Deepest deepest{comm ? comm->max(mine.overlap) : mine.overlap};
    deepest.first = least_of_all(mine.overlap == deepest.overlap ? mine.first : deepest.first);
    deepest.second =
        least_of_all(mine.overlap == deepest.overlap && mine.first == deepest.first ? mine.second : deepest.second);
    if (deepest.overlap > 0)
        throw InputError(fmt::format(
            "{} and {} overlap at the start by {:.3g} of the diameter, and contact.overlap allows {:g}: "
            "move them apart, or let them "
            "start so with allow_overlap = true in [contact]",
            place_in_scene(exposure->scene(), groups, deepest.first),
            place_in_scene(exposure->scene(), groups, deepest.second), deepest.overlap, contact->spec.overlap));
}

} // namespace

void refuse_start(const Communicator& comm, const Threads& threads, const Plan& plan, std::span<const RodGroup> groups,
                  const Rods& rods, Exposure* exposure, Neighbourhood* neighbourhood) {
    refuse(&comm, threads, plan, groups, rods.local(), exposure, neighbourhood);
}

void refuse_start(const SceneSpec& scene, const Plan& plan, std::span<const RodGroup> groups) {
    if (!scene.start.from.empty()) return;
    std::vector<LocalRod> bodies;
    for (const RodGroup& group : groups)
        for (std::int64_t i = 0; i < group.count(); ++i) bodies.push_back({group.first_gid() + i, group.id(), i});
    std::unique_ptr<Exposure> exposure;
    if (plan.has<ContactPlan>()) exposure = std::make_unique<Exposure>(groups, bodies);
    refuse(nullptr, Threads(1), plan, groups, bodies, exposure.get(), nullptr);
}

void refuse_new_walls(const World& world, const Plan& plan, const std::string& stage) {
    const auto *was = world.plan.find<WallPlan>(), *now = plan.find<WallPlan>();
    if (!was || !now) return;
    const double time = world.clock.time();
    const Walls walls(now->walls);
    const auto moved = [&](std::size_t w) {
        return walls.wall[w].servo.drives() ? world.walls()->state[w].offset : walls.at(w, time).offset;
    };
    const auto fault_of = [&](const RodGroup& group, const std::string& what, const Vec3d& place, double radius) {
        for (std::size_t w = 0; w < walls.count(); ++w) {
            const Wall& wall = walls.wall[w];
            if (was->walls[w].stands || !refuses_depth(wall, group, time)) continue;
            const double depth = depth_in(wall, moved(w), place, radius), share = depth / (2 * radius);
            if (share > allowed_in_walls)
                return fmt::format(
                    "{}: {} is {:.3g} m, {:.3g} of its diameter, deep in the wall '{}', which appears at t = {:g} s as "
                    "stage '{}' begins, and {:g} is allowed: let the stage before end where nothing is in its way, put "
                    "it elsewhere, or let it appear there with allow_overlap = true in that [[wall]]",
                    wall.source, what, depth, share, wall.name, time, stage, allowed_in_walls);
        }
        return std::string();
    };
    const auto state_of = [&](const RodGroup& group, std::size_t i) {
        std::vector<Slot<1>> state(static_cast<std::size_t>(group.slots()));
        world.rods().export_rod(i, state);
        synchronise(group, state, world.clock.lag());
        return state;
    };
    const auto [gid, fault] = first_fault(world.groups, world.rods().local(), state_of, fault_of);
    const bool mine_is_first = gid == world.comm.min(gid);
    if (const std::string text = world.comm.first_text(mine_is_first ? fault : ""); !text.empty())
        throw InputError(text);
}

} // namespace skein
