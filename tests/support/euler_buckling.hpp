// Buckling of a clamped rod under a dead force on its free end, along its axis. Linearise theory.md (2) about the
// compressed rod, E A (e - 1)/e = -P: a small turn theta meets the shear force P theta and the moment B theta'/e^3, so
//   (B/e^3) theta'' + P (e + P/(alpha_c G A)) theta = 0,  theta(0) = theta'(L) = 0,   e = 1/(1 + P/(E A)),
// and the critical load is the root of  P (e + P/(alpha_c G A)) e^3 = B (pi/2L)^2: Euler's load pi^2 B/(4 L^2), with
// the exact share of shear and shortening for this law. Where the far end cannot turn, theta(L) = 0: free to move
// sideways it needs no force there, and the load is pi^2 B/L^2; held sideways the lowest form is theta = sin(2 pi s/L),
// which moves the end nowhere, at 4 pi^2 B/L^2. The law `linear` has E A (e - 1) = -P and the moment B theta';
// `elastica` has the shear strain e P theta/(alpha_c G A).
//
// Measured: the slowest motion of the damped rod, a exp(lambda t), obeys lambda^2 + nu lambda + W^2 = 0; the square W^2
// passes through zero at the critical load.
#pragma once

#include "loads/end_force.hpp"
#include "support/relaxation.hpp"

#include <array>
#include <numbers>

namespace skein::test::euler_buckling {

constexpr double radius = 0.05; // L = rho = E = 1
constexpr double area = std::numbers::pi * radius * radius, bending = 0.25 * area * radius * radius,
                 shearing = 27.0 / 28 / 3 * area;
constexpr double euler = 0.25 * std::numbers::pi * std::numbers::pi * bending; ///< N

/// How the loaded end of a clamped rod along z is held.
struct Column {
    const char* name;
    const char* end_free; ///< lab directions in which its clamp slides; empty: no clamp, a free end
    double wave_number;   ///< k of the lowest form, times the length
    double frequency;     ///< the slender rod's first, over the cantilever's
    double look;          ///< where its motion is seen, s/L
};
inline constexpr Column cantilever{"cantilever", "", 0.5 * std::numbers::pi, 1, 1};
inline constexpr Column guided{"guided column", "xz", std::numbers::pi, 5.5933 / 3.5160, 1};
inline constexpr Column sliding{"sliding clamp", "z", 2 * std::numbers::pi, 22.3733 / 3.5160, 0.5};

/// N
inline double critical_load(Law law, const Column& column = cantilever) {
    const double slender = column.wave_number * column.wave_number * bending;
    const auto excess = [&](double p) {
        if (law == Law::linear) return p * (1 - p / area + p / shearing) - slender;
        const double e = 1 / (1 + p / area);
        return p * (e + (law == Law::elastica ? e : 1) * p / shearing) * e * e * e - slender;
    };
    double low = 0, high = 2 * slender;
    for (int i = 0; i < 100; ++i) (excess(0.5 * (low + high)) > 0 ? high : low) = 0.5 * (low + high);
    return 0.5 * (low + high);
}

/// Two rods, one under each load.
inline SceneSpec scene(long n, const std::array<double, 2>& loads, const Column& column = cantilever) {
    RodSpec rod = clamped_unit_rod(n, radius);
    rod.shape.velocity = {1e-6, 0, 0};
    rod.end_free = column.end_free;
    if (!rod.end_free.empty()) rod.end = EndKind::clamped;
    const double omega = column.frequency * cantilever_frequency(rod);
    SceneSpec scene;
    scene.time = {.duration = 30 / omega};
    for (std::size_t i = 0; i < 2; ++i) {
        rod.name = std::string("rod") + std::to_string(i);
        scene.rods.push_back(rod);
        scene.loads.push_back({.load = EndForce{.end = {0, 0, -loads[i]}}, .rods = {rod.name}});
    }
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = 2 * omega}}};
    return scene;
}

/// W^2 over that of the unloaded rod at the two loads; negative where the rod buckles.
inline std::array<double, 2> stiffness(Stage& stage, Cost& cost, const Column& column = cantilever) {
    const double damping = stage.scene.damping[0].damping.rate, omega = damping / 2;
    // All other modes shrink by e^-20 before the first look.
    const auto node = static_cast<std::size_t>(column.look * stage.groups[0].elements());
    const auto tip = [&](std::size_t i) { return lane(stage.state(i)[node].position, 0).x; };
    advance(stage, 2 * stage.plan.steps / 3, cost);
    const std::array<double, 2> first{tip(0), tip(1)};
    const double begin = stage.clock.time();
    advance(stage, stage.plan.steps, cost);
    std::array<double, 2> square{};
    for (std::size_t i = 0; i < 2; ++i) {
        const double lambda = std::log(tip(i) / first[i]) / (stage.clock.time() - begin);
        square[i] = -lambda * (lambda + damping) / (omega * omega);
    }
    return square;
}

/// The load of no stiffness, N: a secant over 2 % about `load`, then a narrower one about what that finds. `stage_of`
/// makes a stage of a scene; `look` sees both loads and their stiffness.
template <class StageOf, class Look> double measured_load(long n, double load, Cost& cost, StageOf&& stage_of,
                                                          Look&& look, const Column& column = cantilever) {
    for (const double width : {2e-2, 1e-3}) {
        const double low = (1 - width) * load, high = (1 + width) * load;
        Stage stage = stage_of(scene(n, {low, high}, column));
        const auto [below, above] = stiffness(stage, cost, column);
        look(stage, width, below, above);
        load = low + (high - low) * below / (below - above);
    }
    return load;
}

} // namespace skein::test::euler_buckling
