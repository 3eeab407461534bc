#include "physics/fluid/stated_speeds.hpp"

#include "immersion/body_surface.hpp"
#include "loads/gravity.hpp"
#include "loads/muscle_formula.hpp"
#include "loads/muscle_torques.hpp"
#include "loads/muscle_wave.hpp"
#include "physics/group_names.hpp"
#include "physics/scene_spec.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include <fmt/format.h>

namespace skein {

namespace {

/// Times of a run that follow no beat, the start first.
std::vector<double> some_times(double duration) {
    constexpr int count = 64;
    std::vector<double> times{0};
    for (int i = 1; i < count; ++i) times.push_back(duration * std::fmod(std::numbers::phi * i, 1.0));
    return times;
}

/// A vertex of a rod that muscles act at: a node between two elements, or a clamped end.
struct Vertex {
    int node = 0;
    double place = 0, length = 0; ///< m: arc length, and what lies between the middles of its elements
    Vec3d stiffness{0, 0, 0};     ///< N m^2
    Vec3d at_rest{0, 0, 0};       ///< rest curvature less that of the start, 1/m
};

std::vector<Vertex> vertices_of(const RodGroup& group) {
    const Shape& shape = group.spec().shape;
    const int n = group.elements();
    const auto start = [&](std::size_t cell, const Vec3d& rest) {
        if (!shape.start_curvature_profile.empty())
            return shape.start_curvature_profile[std::min(cell, shape.start_curvature_profile.size() - 1)];
        return shape.start_curvature.value_or(rest);
    };
    std::vector<Vertex> all;
    double s = 0;
    const auto add = [&](int node, std::size_t cell, const VoronoiConstants& c) {
        all.push_back({.node = node,
                       .place = s,
                       .length = 1 / c.inv_length,
                       .stiffness = c.stiffness,
                       .at_rest = c.rest_curvature - start(cell, c.rest_curvature)});
    };
    if (group.spec().start == EndKind::clamped) add(0, 0, group.start_wall);
    for (int node = 1; node <= n; ++node) {
        s += group.element[static_cast<std::size_t>(node) - 1].rest_length;
        const auto cell = static_cast<std::size_t>(node) - 1;
        if (cell < group.voronoi.size()) add(node, cell, group.voronoi[cell]);
    }
    if (group.spec().end == EndKind::clamped) add(n, group.voronoi.size() - 1, group.end_wall);
    return all;
}

/// Curvature that muscles add to a rod's at rest, about body axes.
struct Bending {
    Vec3d curvature{0, 0, 0}, rate{0, 0, 0}; ///< 1/m, 1/(m s)
};
using Muscle = std::function<Bending(const Vertex&, double time)>;

Vec3d over(const Vec3d& moment, const Vec3d& stiffness) {
    const auto one = [](double m, double b) { return b > 0 ? m / b : 0; };
    return {one(moment.x, stiffness.x), one(moment.y, stiffness.y), one(moment.z, stiffness.z)};
}

/// A wave r(t) A(s) sin(2 pi t/T - phase(s)) about a direction.
template <class Share> Muscle wave(const RodGroup& group, double period, const Ramp& ramp, const Vec3d& direction,
                                   LoadFrame frame, Share share) {
    return [&group, period, ramp, direction, frame, share](const Vertex& at, double time) {
        const auto [amplitude, phase] = share(at.place);
        const double rate = 2 * std::numbers::pi / period, instant = 1e-4 * period, r = ramp.at(time);
        const double before = std::max(0.0, time - instant), after = time + instant,
                     rise = (ramp.at(after) - ramp.at(before)) / (after - before);
        const auto element = static_cast<std::size_t>(std::clamp(at.node, 0, group.elements() - 1));
        const Vec3d about = frame == LoadFrame::body ? direction : group.start_directors()[element] * direction;
        const double angle = rate * time - phase;
        return Bending{
            over((r * amplitude * std::sin(angle)) * about, at.stiffness),
            over((r * amplitude * rate * std::cos(angle) + rise * amplitude * std::sin(angle)) * about, at.stiffness)};
    };
}

double length_of(const RodGroup& group) {
    double length = 0;
    for (const ElementConstants& e : group.element) length += e.rest_length;
    return length;
}

Muscle formula(const RodGroup& group, const MuscleFormula& muscle, const FormulaScope& names, std::int64_t rod) {
    struct Read {
        Graph graph;
        std::array<int, 3> value{}, rate{};
        FormulaPlaces places;
    };
    const bool with_start = !group.places().from_file();
    auto read = std::make_shared<Read>(Read{Graph(names.tables), {}, {}, FormulaPlaces(group, rod, false, with_start)});
    const std::vector<std::string>& texts = muscle.curvature.empty() ? muscle.moment : muscle.curvature;
    std::vector<FormulaFault> found;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto value = read_formula(read->graph, names, texts[i], static_cast<int>(i),
                                        muscle.curvature.empty() ? "N m" : "1/m", found);
        if (!value) return {}; // its faults are told elsewhere
        read->value[i] = value->node;
    }
    for (std::size_t i = 0; i < 3; ++i) read->rate[i] = read->graph.derivative(read->value[i], Variable::t);
    const bool moment = muscle.curvature.empty(), lab = muscle.frame == LoadFrame::lab;
    return [read, moment, lab, &group](const Vertex& at, double time) {
        std::array<double, variables> values{};
        for (int v = static_cast<int>(Variable::s); v < variables; ++v)
            nth(values, v) = read->places.value(static_cast<Variable>(v), static_cast<std::size_t>(at.node));
        nth(values, Variable::t) = time;
        const std::vector<double> all = read->graph.values(values);
        const auto vector = [&](const std::array<int, 3>& nodes) {
            const auto of = [&](std::size_t i) {
                const double x = nth(all, nodes[i]);
                return std::isfinite(x) ? x
                                        : 0.0; // the derivative of a root may have a pole where the root itself is 0
            };
            Vec3d v{of(0), of(1), of(2)};
            const auto element = static_cast<std::size_t>(std::clamp(at.node, 0, group.elements() - 1));
            if (lab) v = group.start_directors()[element] * v;
            return moment ? over(v, at.stiffness) : v;
        };
        return Bending{vector(read->value), vector(read->rate)};
    };
}

/// The muscles of a group's rod.
std::vector<Muscle> muscles_of(const SceneSpec& scene, const RodGroup& group, std::span<const Load> loads,
                               std::int64_t rod) {
    std::vector<Muscle> all;
    const double length = length_of(group);
    for (std::size_t i = 0; i < loads.size(); ++i) {
        if (!names_group(scene.loads[i].rods, group.name()) || !loads[i].acts_on(group.spec())) continue;
        if (const auto* m = loads[i].get_if<MuscleFormula>())
            if (Muscle one = formula(group, *m, names_for_formulas(scene), rod)) all.push_back(std::move(one));
        if (const auto* m = loads[i].get_if<MuscleWave>())
            all.push_back(wave(group, m->period, m->ramp, m->direction, m->frame, [m, length, &group](double s) {
                const int last = group.elements() - 1,
                          j = std::clamp(static_cast<int>(std::lround(s / length * (last + 1))), 1, last);
                return std::pair(m->amplitude * m->share(j, s, length), m->phase_at(s));
            }));
        if (const auto* m = loads[i].get_if<MuscleTorques>())
            all.push_back(wave(group, m->period, m->ramp, m->direction, m->frame, [m, length, &group](double s) {
                const double back = 1 - s / length; // from the end to the start
                const int at =
                    std::clamp(static_cast<int>(std::lround(back * group.elements())) - 1, 0, group.elements() - 1);
                return std::pair(m->amplitude_at(std::clamp(back, 0.0, 1.0), static_cast<std::size_t>(at)),
                                 m->phase_at(back));
            }));
    }
    return all;
}

/// Calls f with the group, or with the constants of some rods that have sizes of their own.
template <class F> void for_some_kinds(const RodGroup& group, F&& f) {
    constexpr std::size_t most = 64;
    if (!group.heterogeneous()) return f(group);
    const std::vector<std::int64_t> rods = group.places().held();
    for (std::size_t i = 0; i < rods.size(); i += rods.size() / most + 1) f(group.single(rods[i]));
}

/// Some of a group's rods, among them the first; of a file that alone, which all ranks know as the group has it.
std::vector<std::int64_t> some_rods(const RodGroup& group) {
    constexpr std::int64_t most = 4;
    std::vector<std::int64_t> rods{group.single_rod().value_or(0)};
    if (group.places().from_file() || group.single_rod()) return rods;
    for (std::int64_t i = 1; i < std::min(most, group.count()); ++i)
        rods.push_back(i * (group.count() - 1) / (most - 1));
    return rods;
}

/// Inertia of a rod and of as much fluid, by length, at a vertex; kg/m.
double inertia_at(const RodGroup& group, const Vertex& at, double fluid_density) {
    const ElementConstants& e = nth(group.element, std::clamp(at.node, 0, group.elements() - 1));
    return (group.spec().material.density + fluid_density) * e.volume * e.inv_rest_length;
}

/// The largest speed that bending by this curvature has room for: all of its energy becomes kinetic.        theory.md
/// (93)
double speed_of_release(const RodGroup& group, const Vertex& at, const Vec3d& curvature, double fluid_density) {
    return std::sqrt(dot(scale(at.stiffness, curvature), curvature) / inertia_at(group, at, fluid_density));
}

/// Velocities of nodes of a rod whose curvature changes at these rates, less what carries and turns it as a whole where
/// its ends are free. theory.md (94)
double speed_of_bending(const RodGroup& group, std::span<const Vertex> vertices, std::span<const Vec3d> rates) {
    const std::size_t n = group.element.size();
    std::vector<Vec3d> velocity{{0, 0, 0}};
    std::vector<double> place{0};
    Vec3d spin{0, 0, 0};
    std::size_t next = 0;
    for (std::size_t k = 0; k < n; ++k) {
        for (; next < vertices.size() && vertices[next].node <= static_cast<int>(k); ++next)
            spin += vertices[next].length * transpose_times(group.start_directors()[k], rates[next]);
        const double l = group.element[k].rest_length;
        const Vec3d along = transpose_times(group.start_directors()[k], Vec3d{0, 0, l});
        velocity.push_back(velocity.back() + cross(spin, along));
        place.push_back(place.back() + l);
    }
    const bool from_start = group.spec().start != EndKind::free, from_end = group.spec().end != EndKind::free;
    if (!group.closed() && group.spec().start == EndKind::clamped && !from_end) { // it moves against the clamp
        double most = 0;
        for (const Vec3d& v : velocity) most = std::max(most, sum_of(v));
        return most;
    }
    double count = 0, first = 0, second = 0; // moments of places
    Vec3d mean{0, 0, 0}, slope{0, 0, 0};
    for (std::size_t i = 0; i < place.size(); ++i) {
        count += 1;
        first += place[i];
    }
    first /= count;
    for (std::size_t i = 0; i < place.size(); ++i) {
        mean += (1 / count) * velocity[i];
        second += (place[i] - first) * (place[i] - first);
    }
    for (std::size_t i = 0; i < place.size(); ++i) slope += ((place[i] - first) / second) * velocity[i];
    if (from_start) mean = velocity.front() + first * slope; // a pinned end stays
    double most = 0;
    for (std::size_t i = 0; i < place.size(); ++i)
        most = std::max(most, sum_of(velocity[i] - mean - (place[i] - first) * slope));
    return most;
}

/// Speed of a rod that falls or rises: as far as the duration, inertial or viscous drag on a cylinder let it.
double speed_of_weight(const RodGroup& group, const Vec3d& gravity, const FluidSpec& fluid, double duration) {
    const double density = group.spec().material.density, excess = std::abs(density - fluid.density),
                 g = sum_of(gravity);
    double radius = 0;
    for (const ElementConstants& e : group.element) radius = std::max(radius, e.radius);
    const double slender = 1 + std::log(std::max(1.0, length_of(group) / (2 * radius)));
    const double viscous =
        fluid.viscosity > 0 ? excess * g * radius * radius * slender / (4 * fluid.viscosity) : HUGE_VAL;
    return std::min(
        {excess / density * g * duration, std::sqrt(std::numbers::pi * radius * g * excess / fluid.density), viscous});
}

/// Speed of a body that falls or rises: as far as the duration, inertial or viscous drag on a sphere of its volume let
/// it.
double speed_of_weight(const RodGroup& group, const BodyShape& body, const Vec3d& gravity, const FluidSpec& fluid,
                       double duration) {
    constexpr double drag_coefficient = 0.44; // of a sphere at Reynolds numbers above 1000
    const double volume = displaced_volume(body).volume, displaced = fluid.density * volume,
                 weight = std::abs(group.node_mass.front() - displaced) * sum_of(gravity),
                 radius = std::cbrt(0.75 * volume / std::numbers::pi);
    const double viscous = fluid.viscosity > 0 ? weight / (6 * std::numbers::pi * fluid.viscosity * radius) : HUGE_VAL;
    return std::min({weight / (group.node_mass.front() + 0.5 * displaced) * duration,
                     std::sqrt(2 * weight / (drag_coefficient * fluid.density * std::numbers::pi * radius * radius)),
                     viscous});
}

/// Speeds of both ends of a group's rods that move as prescribed.
double speed_of_motions(const RodGroup& group, double duration) {
    const RodSpec& spec = group.spec();
    const double length = length_of(group);
    double most = 0;
    for (const EndMotion* motion : {&spec.start_motion, &spec.end_motion})
        if (motion->moves() || motion->turns())
            for (const double t : some_times(duration))
                most = std::max(most, sum_of(motion->displacement(t).rate) + length * norm(motion->turn(t).rate));
    return most;
}

double speed_at_start(const RodGroup& group) {
    const Shape& shape = group.spec().shape;
    const double arm = group.body() ? group.body()->reach : 0.5 * length_of(group);
    return sum_of(shape.velocity) + arm * norm(shape.angular_velocity);
}

/// Calls f(vertices, muscles) for some rods of a group.
template <class F>
void for_bent_rods(const SceneSpec& scene, const RodGroup& group, std::span<const Load> loads, F&& f) {
    if (!group.strained()) return;
    const std::vector<Vertex> vertices = vertices_of(group);
    for (const std::int64_t rod : some_rods(group)) f(vertices, muscles_of(scene, group, loads, rod));
}

Bending sum_over(const std::vector<Muscle>& muscles, const Vertex& at, double time) {
    Bending sum;
    for (const Muscle& muscle : muscles) {
        const Bending one = muscle(at, time);
        sum.curvature += one.curvature;
        sum.rate += one.rate;
    }
    return sum;
}

/// Curvature of muscles and rest at t = 0 less that of the shape: where it is worth most.
struct Release {
    double speed = 0;
    Vec3d curvature{0, 0, 0};
    double length = 0; ///< of the cell, m
};
Release release_of(const SceneSpec& scene, const RodGroup& group, std::span<const Load> loads) {
    Release most;
    for_bent_rods(scene, group, loads, [&](const std::vector<Vertex>& vertices, const std::vector<Muscle>& muscles) {
        for (const Vertex& at : vertices) {
            const Vec3d more = at.at_rest + sum_over(muscles, at, 0).curvature;
            if (const double speed = speed_of_release(group, at, more, scene.fluid->density); speed > most.speed)
                most = {speed, more, at.length};
        }
    });
    return most;
}

/// Speed by muscles whose curvature changes in time: that of the rates, at most that of their energy.
double speed_of_muscles(const SceneSpec& scene, const RodGroup& group, std::span<const Load> loads) {
    double most = 0;
    for_bent_rods(scene, group, loads, [&](const std::vector<Vertex>& vertices, const std::vector<Muscle>& muscles) {
        if (muscles.empty()) return;
        double room = 0, kinematic = 0;
        std::vector<Vec3d> rates(vertices.size());
        for (const double t : some_times(scene.time.duration)) {
            for (std::size_t v = 0; v < vertices.size(); ++v) {
                const Bending here = sum_over(muscles, vertices[v], t);
                rates[v] = here.rate;
                room = std::max(room, speed_of_release(group, vertices[v], here.curvature, scene.fluid->density));
            }
            kinematic = std::max(kinematic, speed_of_bending(group, vertices, rates));
        }
        most = std::max(most, std::min(room, kinematic));
    });
    return most;
}

} // namespace

std::vector<StatedSpeed> stated_speeds(const SceneSpec& scene, std::span<const RodGroup> groups,
                                       std::span<const Load> loads) {
    std::vector<StatedSpeed> all;
    const auto take = [&](double value, const std::string& by, bool at_once) {
        if (!(value > 0)) return;
        const auto known = std::find_if(all.begin(), all.end(), [&](const StatedSpeed& one) { return one.by == by; });
        if (known == all.end()) all.push_back({value, by, at_once});
        else known->value = std::max(known->value, value);
    };
    const auto take_all_of = [&](const RodGroup& group) {
        const std::string of = fmt::format("of '{}'", group.name());
        take(speed_at_start(group), "the velocity at the start " + of, true);
        take(speed_of_motions(group, scene.time.duration), "the moved ends " + of, false);
        if (scene.immersion.coupling == RodCoupling::two_way) {
            Vec3d gravity{0, 0, 0};
            for (std::size_t i = 0; i < loads.size(); ++i)
                if (const auto* g = loads[i].get_if<Gravity>(); g && names_group(scene.loads[i].rods, group.name()))
                    gravity += g->acceleration;
            const double duration = scene.time.duration;
            take(group.body() ? speed_of_weight(group, *group.body(), gravity, *scene.fluid, duration)
                              : speed_of_weight(group, gravity, *scene.fluid, duration),
                 "the weight " + of, false);
        }
        if (!group.strained()) return;
        take(release_of(scene, group, loads).speed, fmt::format("the curvature {} that begins at t = 0", of), true);
        take(speed_of_muscles(scene, group, loads), "the muscles " + of, false);
    };
    for (const RodGroup& group : groups) for_some_kinds(group, take_all_of);
    return all;
}

std::vector<std::string> abrupt_starts(const SceneSpec& scene, std::span<const RodGroup> groups,
                                       std::span<const Load> loads) {
    constexpr double share = 1e-3; // rad of a cell
    std::vector<std::string> found;
    for (const RodGroup& group : groups) {
        Release release;
        for_some_kinds(group, [&](const RodGroup& kind) {
            if (const Release of = release_of(scene, kind, loads); of.speed > release.speed) release = of;
        });
        if (!(norm(release.curvature) * release.length > share)) continue;
        found.push_back(fmt::format(
            "rods.{}: muscles and rest curvature differ from the shape at t = 0 by up to {:.3g} 1/m: the rod "
            "starts with a shock, of up to {:.3g} m/s, and how far it gets then depends on the grid and the "
            "step by tens of percent; a factor such as ramp(t, T) in a formula lets muscles begin at 0",
            group.name(), norm(release.curvature), release.speed));
    }
    return found;
}

} // namespace skein
