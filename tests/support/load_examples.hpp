// An example of every load, and what a test must know of it: how it turns with its scene, whether it is internal, its
// potential. Tests of all loads run over this list, and fail for a load of the scenes' list that is not in it.
#pragma once

#include "loads/load_list.hpp"
#include "loads/load_pass.hpp"
#include "skein/core/index.hpp"
#include "support/rods_for_tests.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

namespace skein::test {

using State = std::vector<Slot<1>>;

/// A scene turned about the origin, then shifted.
struct Turn {
    Quaterniond frame = no_turn;
    Vec3d shift{0, 0, 0};

    Vec3d direction(const Vec3d& a) const { return transpose_times(frame, a); }
    Vec3d point(const Vec3d& x) const { return direction(x) + shift; }
    Quaterniond director(const Quaterniond& q) const { return q * frame; }

    RodSpec rod(RodSpec spec) const {
        const Vec3d normal = spec.placement.normal.value_or(Vec3d{1, 0, 0});
        spec.placement.origin = point(spec.placement.origin);
        spec.placement.tangent = direction(spec.placement.tangent);
        spec.placement.normal = direction(normal);
        spec.shape.velocity = direction(spec.shape.velocity);
        spec.magnetisation.direction = direction(spec.magnetisation.direction);
        return spec;
    }
    State state(State s) const {
        for (Slot<1>& slot : s) {
            set_lane(slot.position, 0, point(lane(slot.position, 0)));
            set_lane(slot.velocity, 0, direction(lane(slot.velocity, 0)));
            set_lane(slot.director, 0, director(lane(slot.director, 0)));
        }
        return s;
    }
};

/// Energy, J, of a rod in a state at a time, s.
using Potential = std::function<double(const RodGroup&, const State&, double time)>;

struct LoadExample {
    Load load;
    std::function<void(Load&, const Turn&)> turn; ///< its lab vectors and points
    bool internal = false;                        ///< without net force and couple, whatever the state
    Potential potential = {};                     ///< none: its forces are not those of an energy

    std::string name() const { return std::string(load.kind()) + (internal ? ", internal" : ""); }
};

/// Moment of vertex k + 1 of an even rod of length 1 times the rotation of its cell about a material axis.
inline double actuation(const RodGroup& group, const State& s, const Vec3d& axis,
                        const std::function<double(int)>& moment) {
    double sum = 0;
    for (int k = 0; k + 1 < group.elements(); ++k) {
        const auto at = static_cast<std::size_t>(k);
        sum += moment(k + 1) * dot(axis, relative_rotation(lane(s[at + 1].director, 0), lane(s[at].director, 0)));
    }
    return sum;
}

/// A wave that fades along the rod, about a.
inline MuscleFormula muscles_by_formula(const Vec3d& a, LoadFrame frame) {
    MuscleFormula load{.frame = frame};
    for (const double part : {a.x, a.y, a.z})
        load.moment.push_back(fmt::format("({:.17g})*0.3*exp(-1*s)*sin(pi*t - 8*s)", part));
    load.use({.duration = 1});
    return load;
}

/// a.(x - p) as a formula.
inline std::string along(const Vec3d& a, const Vec3d& p) {
    return fmt::format("(({:.17g})*(x-({:.17g}))+({:.17g})*(y-({:.17g}))+({:.17g})*(z-({:.17g})))", a.x, p.x, a.y, p.y,
                       a.z, p.z);
}

/// A spring of 3 N/m^2 per length along a, from the plane through p.
inline FormulaLoad spring_by_formula(const Vec3d& a, const Vec3d& p) {
    FormulaLoad load;
    for (const double part : {a.x, a.y, a.z}) load.force.push_back(fmt::format("-3*({:.17g})*{}", part, along(a, p)));
    load.use({.duration = 1});
    return load;
}

/// The field c + b (a.(x - p)), T.
inline MagneticFormula field_by_formula(const Vec3d& a, const Vec3d& p, const Vec3d& b, const Vec3d& c) {
    MagneticFormula load;
    for (const auto& [by, constant] : {std::pair{b.x, c.x}, {b.y, c.y}, {b.z, c.z}})
        load.field.push_back(fmt::format("({:.17g})+({:.17g})*{}", constant, by, along(a, p)));
    load.use({.duration = 1});
    return load;
}

/// A spring that holds the first node to p from the middle of its rod.
inline Guide guide_to(const Vec3d& p) {
    Guide load{.stiffness = 3, .along = "xyz", .place = {}};
    for (const double part : {p.x, p.y, p.z}) load.place.push_back(fmt::format("{:.17g} * (1 + sin(2 * t))", part));
    load.use({.duration = 1});
    return load;
}

inline std::vector<LoadExample> load_examples() {
    const auto at = [](const State& s, std::size_t i) { return lane(s[i].position, 0); };
    const auto still = [](Load&, const Turn&) {};
    constexpr double pi = std::numbers::pi;
    std::vector<LoadExample> all;

    const Gravity gravity{.acceleration = {1, 2, -9}};
    all.push_back(
        {gravity,
         [](Load& l, const Turn& t) { l.as<Gravity>().acceleration = t.direction(l.as<Gravity>().acceleration); },
         false,
         [=](const RodGroup& group, const State& s, double) {
             double u = 0;
             for (std::size_t i = 0; i < s.size(); ++i) u -= group.node_mass[i] * dot(gravity.acceleration, at(s, i));
             return u;
         }});

    const UniformForce force{.force = {0.3, -0.2, -0.5}, .ramp = {2}};
    all.push_back({force,
                   [](Load& l, const Turn& t) { l.as<UniformForce>().force = t.direction(l.as<UniformForce>().force); },
                   false,
                   [=](const RodGroup& group, const State& s, double time) {
                       double u = 0;
                       for (std::size_t k = 0; k + 1 < s.size(); ++k)
                           u -= force.ramp.at(time) * group.element[k].rest_length / group.spec().shape.length *
                                dot(force.force, 0.5 * (at(s, k) + at(s, k + 1)));
                       return u;
                   }});

    all.push_back({UniformCouple{.couple = {0.1, -0.3, 0.2}}, [](Load& l, const Turn& t) {
                       l.as<UniformCouple>().couple = t.direction(l.as<UniformCouple>().couple);
                   }});

    const EndForce ends{.start = {0.3, 0.1, -0.2}, .end = {-0.2, 0.4, -0.1}, .ramp = {3}};
    all.push_back({ends,
                   [](Load& l, const Turn& t) {
                       EndForce& e = l.as<EndForce>();
                       e.start = t.direction(e.start);
                       e.end = t.direction(e.end);
                   },
                   false,
                   [=](const RodGroup&, const State& s, double time) {
                       return -ends.ramp.at(time) * (dot(ends.start, at(s, 0)) + dot(ends.end, at(s, s.size() - 1)));
                   }});

    all.push_back({EndForce{.start = {0.3, 0.1, -0.2}, .end = {-0.2, 0.4, -0.1}, .frame = LoadFrame::body, .ramp = {3}},
                   [](Load&, const Turn&) {}});

    for (const LoadFrame frame : {LoadFrame::lab, LoadFrame::body})
        all.push_back({EndCouple{.start = {0.1, 0.2, -0.3}, .end = {0.3, -0.1, 0.2}, .frame = frame, .ramp = {2}},
                       [](Load& l, const Turn& t) {
                           EndCouple& e = l.as<EndCouple>();
                           if (e.frame == LoadFrame::lab) {
                               e.start = t.direction(e.start);
                               e.end = t.direction(e.end);
                           }
                       }});

    const MagneticField field{.constant = {0.01, 0.02, -0.05}, .rotating = 0.08, .period = 7};
    all.push_back({field,
                   [](Load& l, const Turn& t) {
                       MagneticField& f = l.as<MagneticField>();
                       f.constant = t.direction(f.constant);
                       f.sine_axis = t.direction(f.sine_axis);
                       f.cosine_axis = t.direction(f.cosine_axis);
                   },
                   false,
                   [=](const RodGroup& group, const State& s, double time) {
                       double u = 0;
                       for (std::size_t k = 0; k + 1 < s.size(); ++k)
                           u -= group.element[k].volume * group.spec().magnetisation.strength *
                                dot(group.start_directors()[k] * group.magnetisation(0),
                                    lane(s[k].director, 0) * field.at(time));
                       return u;
                   }});

    for (const LoadFrame frame : {LoadFrame::lab, LoadFrame::body}) {
        const bool body = frame == LoadFrame::body;
        const MuscleWave wave{
            .amplitude = 0.3, .period = 2, .wavelength = 0.8, .phase = 0.4, .direction = {0.6, 0, 0.8}, .frame = frame};
        all.push_back({wave,
                       [](Load& l, const Turn& t) {
                           MuscleWave& w = l.as<MuscleWave>();
                           if (w.frame == LoadFrame::lab) w.direction = t.direction(w.direction);
                       },
                       true, !body ? Potential{} : [=](const RodGroup& group, const State& s, double time) {
                           double arc = 0;
                           return -actuation(group, s, wave.direction, [&](int j) {
                               arc += nth(group.element, j - 1).rest_length;
                               return 0.3 * std::sin(pi * time - 2 * pi / 0.8 * arc + 0.4);
                           });
                       }});
        const MuscleTorques torques{.coefficients = {0, 0.3, 0.2, 0.1, 0.4},
                                    .period = 2,
                                    .wave_number = 5,
                                    .phase = 0.4,
                                    .direction = {0, 0.6, 0.8},
                                    .frame = frame};
        all.push_back({torques,
                       [](Load& l, const Turn& t) {
                           MuscleTorques& w = l.as<MuscleTorques>();
                           if (w.frame == LoadFrame::lab) w.direction = t.direction(w.direction);
                       },
                       true, !body ? Potential{} : [=](const RodGroup& group, const State& s, double time) {
                           const int n = group.elements();
                           return -actuation(group, s, torques.direction, [&](int j) {
                               double arc = 0, length = 0;
                               for (int i = 0; i < n; ++i) {
                                   length += nth(group.element, i).rest_length;
                                   if (i <= n - 1 - j) arc = length;
                               }
                               return cubic_bspline(torques.coefficients, arc / length) *
                                      std::sin(pi * time - 5 * arc / length + 0.4);
                           });
                       }});
    }

    for (const LoadFrame frame : {LoadFrame::lab, LoadFrame::body}) {
        const bool body = frame == LoadFrame::body;
        all.push_back({muscles_by_formula(Vec3d{0.6, 0, 0.8}, frame),
                       [=](Load& l, const Turn& t) {
                           if (!body) l = muscles_by_formula(t.direction(Vec3d{0.6, 0, 0.8}), frame);
                       },
                       true, !body ? Potential{} : [=](const RodGroup& group, const State& s, double time) {
                           double arc = 0;
                           return -actuation(group, s, Vec3d{0.6, 0, 0.8}, [&](int j) {
                               arc += nth(group.element, j - 1).rest_length;
                               return 0.3 * std::exp(-arc) * std::sin(pi * time - 8 * arc);
                           });
                       }});
    }

    const SinusoidalEndForce turning{
        .start = 2, .end = -3, .normal = {0, 0.6, 0.8}, .tangent = {0, -0.8, 0.6}, .hold = 0.5};
    all.push_back({turning,
                   [](Load& l, const Turn& t) {
                       SinusoidalEndForce& f = l.as<SinusoidalEndForce>();
                       f.normal = t.direction(f.normal);
                       f.tangent = t.direction(f.tangent);
                   },
                   false,
                   [=](const RodGroup&, const State& s, double time) {
                       return -dot(turning.at(time), turning.start * at(s, 0) + turning.end * at(s, s.size() - 1));
                   }});

    all.push_back({SlenderBodyDrag{.viscosity = 0.3}, still});

    PlaneFriction ground{
        .point = {0, 0, 0.1}, .normal = {0.1, -0.2, 1}, .stiffness = 10, .damping = 0.1, .tolerance = 0.3};
    ground.kinetic_forward = 0.3;
    ground.kinetic_backward = 0.4;
    ground.kinetic_sideways = 0.5;
    ground.static_forward = 0.5;
    ground.static_backward = 0.6;
    ground.static_sideways = 0.7;
    ground.slip_speed = 1;
    all.push_back({ground, [](Load& l, const Turn& t) {
                       PlaneFriction& p = l.as<PlaneFriction>();
                       p.point = t.point(p.point);
                       p.normal = t.direction(p.normal);
                   }});

    const Vec3d a{0.48, 0.6, -0.64}, p{0.1, 0.2, 0.3}, b{0.2, -0.1, 0.3}, c{0.01, 0.03, -0.02};
    all.push_back({spring_by_formula(a, p),
                   [=](Load& l, const Turn& t) { l = spring_by_formula(t.direction(a), t.point(p)); }, false,
                   [=](const RodGroup& group, const State& s, double) {
                       double u = 0;
                       for (std::size_t i = 0; i < s.size(); ++i)
                           u += 1.5 * group.node_length[i] * std::pow(dot(a, at(s, i) - p), 2);
                       return u;
                   }});
    all.push_back({field_by_formula(a, p, b, c),
                   [=](Load& l, const Turn& t) {
                       l = field_by_formula(t.direction(a), t.point(p), t.direction(b), t.direction(c));
                   },
                   false,
                   [=](const RodGroup& group, const State& s, double) {
                       double u = 0;
                       for (std::size_t k = 0; k + 1 < s.size(); ++k) {
                           const Vec3d b_here = c + dot(a, 0.5 * (at(s, k) + at(s, k + 1)) - p) * b;
                           u -= group.element[k].volume * group.spec().magnetisation.strength *
                                dot(group.start_directors()[k] * group.magnetisation(0),
                                    lane(s[k].director, 0) * b_here);
                       }
                       return u;
                   }});
    all.push_back({guide_to(b), [=](Load& l, const Turn& t) { l = guide_to(t.direction(b)); }});
    return all;
}

} // namespace skein::test
