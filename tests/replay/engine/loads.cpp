#include "loads.hpp"

#include "loads/gravity.hpp"
#include "loads/sinusoidal_end_force.hpp"
#include "loads/slender_body_drag.hpp"
#include "skein/core/index.hpp"
#include "skein/loads/ramp.hpp"

#include <cmath>
#include <numbers>

namespace skein::replay {

namespace {

using std::numbers::pi;

Quaterniond at(const Quaternion<Pack<1>>& q) { return lane(q, 0); }
void add_force(SlotLoad<1>& load, const Vec3d& f) { load.force += broadcast<1>(f); }
void add_couple(SlotLoad<1>& load, const Vec3d& c) { load.couple += broadcast<1>(c); }

/// The node that the file's lists end with; a ring's slot n is a copy of node 0.
int last_node(const RodTile<1>& rod) { return rod.group->closed() ? rod.n - 1 : rod.n; }

/// Ramped forces on the first and last node.
struct EndForces {
    static constexpr std::string_view kind = "endpoint_forces";
    Vec3d start, end;
    double ramp;
    void add(const RodTile<1>& rod, SlotLoad<1>* load, const Step& step) const {
        add_force(load[0], ramp_at(step.time, ramp) * start);
        add_force(load[last_node(rod)], ramp_at(step.time, ramp) * end);
    }
};

/// The library's turning forces, on the nodes that the file's lists begin and end with.
struct TurningEndForces : SinusoidalEndForce {
    void add(const RodTile<1>& rod, SlotLoad<1>* load, const Step& step) const {
        add_force(load[0], start * direction[step.slot]);
        add_force(load[last_node(rod)], end * direction[step.slot]);
    }
};

/// f_i = F/n at nodes, half of it at the first and last (a ring's too).
struct UniformForces {
    static constexpr std::string_view kind = "uniform_forces";
    Vec3d force;
    void add(const RodTile<1>& rod, SlotLoad<1>* load, const Step&) const {
        const int last = last_node(rod);
        for (int i = 0; i <= last; ++i) add_force(load[i], ((i == 0 || i == last ? 0.5 : 1.0) / rod.n) * force);
    }
};

/// c_k = Q_k T/n.
struct UniformTorques {
    static constexpr std::string_view kind = "uniform_torques";
    Vec3d torque;
    void add(const RodTile<1>& rod, SlotLoad<1>* load, const Step&) const {
        for (int k = 0; k < rod.n; ++k) add_couple(load[k], at(rod.slot[k].director) * ((1.0 / rod.n) * torque));
    }
};

/// a_k = r(t) spline_k sin(2 pi t/period - wave_number s_k + phase); T_k = a_{n-1-k} direction (lab), between elements
/// k-1 and k.
struct MuscleTorques {
    static constexpr std::string_view kind = "muscle_torques";
    double ramp, period, wave_number, phase;
    std::vector<double> s, spline;
    Vec3d direction;
    void add(const RodTile<1>& rod, SlotLoad<1>* load, const Step& step) const {
        for (int k = 1; k < rod.n; ++k) {
            const auto j = static_cast<std::size_t>(rod.n - 1 - k);
            const double a = ramp_at(step.time, ramp) * spline[j] *
                             std::sin(2 * pi / period * step.time - wave_number * s[j] + phase);
            add_couple(load[k], at(rod.slot[k].director) * (a * direction));
            add_couple(load[k - 1], at(rod.slot[k - 1].director) * (-a * direction));
        }
    }
};

/// c_k = m_k x Q_k b(t); b rises after `start` and falls after `end`; the oscillating one is times sin(w t + phase) by
/// component.
struct Magnetic {
    static constexpr std::string_view kind = "magnetic";
    static constexpr double tolerance = 2.220446049250313e-12; ///< on the ramp, s, as published
    std::vector<Vec3d> moment;                                 ///< A m^2, body
    Vec3d amplitude, frequency, phase;
    bool oscillating;
    double ramp, start, end;
    Vec3d field(double t) const {
        const double width = ramp + tolerance;
        const double r = t <= start ? 0.0
                         : t <= end ? std::min(1.0, (t - start) / width)
                                    : std::max(0.0, 1 - (t - end) / width);
        if (!oscillating) return r * amplitude;
        return scale(r * amplitude, Vec3d{std::sin(frequency.x * t + phase.x), std::sin(frequency.y * t + phase.y),
                                          std::sin(frequency.z * t + phase.z)});
    }
    void add(const RodTile<1>& rod, SlotLoad<1>* load, const Step& step) const {
        const Vec3d b = field(step.time);
        for (int k = 0; k < rod.n; ++k) add_couple(load[k], cross(nth(moment, k), at(rod.slot[k].director) * b));
    }
};

/// One for all components, or one each.
Vec3d one_or_three(const Entry& e) {
    if (!e.json().is_number()) return e.vector();
    const double a = e.number();
    return {a, a, a};
}

Magnetic magnetic(const Entry& e, std::size_t n) {
    const std::string field = e["field"].text();
    if (field != "constant" && field != "oscillating")
        throw NotBuilt("magnetic field '" + field + "' (" + e.path() + ")");
    const bool oscillating = field == "oscillating";
    const Vec3d none{0, 0, 0};
    return {e["moment_material_frame"].vectors(n),
            e["amplitude"].vector(),
            oscillating ? one_or_three(e["angular_frequency"]) : none,
            oscillating ? one_or_three(e["phase"]) : none,
            oscillating,
            e["ramp_interval"].number(),
            e["start_time"].number(),
            e["end_time"].number()};
}

} // namespace

std::unique_ptr<TilePass<1>> make_load(const Entry& e, const RodGroup& group) {
    const std::string kind = e["kind"].text();
    const auto n = static_cast<std::size_t>(group.elements());
    const auto pass = [&]<class L>(L load) -> std::unique_ptr<TilePass<1>> {
        return std::make_unique<LoadPass<L, 1>>(std::move(load), group);
    };
    if (kind == "gravity") return pass(Gravity{e["acc"].vector()});
    if (kind == "uniform_torques") return pass(UniformTorques{e["torque"].vector()});
    if (kind == "magnetic") return pass(magnetic(e, n));
    if (kind == "endpoint_forces")
        return pass(EndForces{e["start_force"].vector(), e["end_force"].vector(), e["ramp_up_time"].number()});
    if (kind == "uniform_forces") return pass(UniformForces{e["force"].vector()});
    if (kind == "muscle_torques")
        return pass(MuscleTorques{e["ramp_up_time"].number(), e["period"].positive(), e["wave_number"].number(),
                                  e["phase_shift"].number(), e["s"].numbers(n), e["spline_at_s"].numbers(n),
                                  e["direction"].vector()});
    if (kind == "endpoint_forces_sinusoidal")
        return pass(TurningEndForces{{.start = e["start_force_mag"].number(),
                                      .end = e["end_force_mag"].number(),
                                      .normal = e["normal_direction"].vector(),
                                      .tangent = e["tangent_direction"].vector(),
                                      .hold = e["ramp_up_time"].number()}});
    // Published codes have no velocity of a ring's closing element.
    if (group.closed() && kind == "slender_body") throw NotBuilt("load 'slender_body' on a ring (" + e.path() + ")");
    if (kind == "slender_body") return pass(SlenderBodyDrag{e["dynamic_viscosity"].number()});
    throw NotBuilt("load '" + kind + "' (" + e.path() + ")");
}

} // namespace skein::replay
