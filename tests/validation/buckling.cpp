// Buckling of a clamped rod under a dead force on its free end, along its axis. Linearise (2) about the compressed rod,
// E A (e - 1)/e = -P: a small turn theta meets the shear force P theta and the moment B theta'/e^3, so
//   (B/e^3) theta'' + P (e + P/(alpha_c G A)) theta = 0,  theta(0) = theta'(L) = 0,   e = 1/(1 + P/(E A)),
// and the critical load is the root of  P (e + P/(alpha_c G A)) e^3 = B (pi/2L)^2: Euler's load pi^2 B/(4 L^2), with the exact
// share of shear and shortening for this law.
//
// Measured: the slowest motion of the damped rod, a exp(lambda t), obeys lambda^2 + nu lambda + W^2 = 0; the square W^2 passes
// through zero at the critical load.
#include "validation/study.hpp"

#include <array>
#include <numbers>

namespace skein {
namespace {

constexpr double radius = 0.05; // L = rho = E = 1
constexpr double area = std::numbers::pi * radius * radius, bending = 0.25 * area * radius * radius,
                 shearing = 27.0 / 28 / 3 * area;
constexpr double euler = 0.25 * std::numbers::pi * std::numbers::pi * bending;

double critical_load() {
    const auto excess = [](double p) {
        const double e = 1 / (1 + p / area);
        return p * (e + p / shearing) * e * e * e - euler;
    };
    double low = 0, high = 2 * euler;
    for (int i = 0; i < 100; ++i) (excess(0.5 * (low + high)) > 0 ? high : low) = 0.5 * (low + high);
    return 0.5 * (low + high);
}

/// W^2 over that of the unloaded rod at two loads; negative where the rod buckles.
std::array<double, 2> stiffness(long n, std::array<double, 2> loads, double& dt, test::Cost& cost) {
    RodSpec rod = test::clamped_unit_rod(n, radius);
    rod.shape.velocity = {1e-6, 0, 0};
    const double omega = test::cantilever_frequency(rod), damping = 2 * omega;
    SceneSpec scene;
    scene.time = {.duration = 30 / omega};
    for (std::size_t i = 0; i < 2; ++i) {
        rod.name = std::string("rod") + std::to_string(i);
        scene.rods.push_back(rod);
        scene.loads.push_back({.load = EndForce{.end = {0, 0, -loads[i]}}, .rods = {rod.name}});
    }
    scene.damping = {{.damping = {.kind = DampingKind::uniform, .rate = damping}}};
    test::Stage stage(scene, 1);
    dt = stage.plan.dt;

    // All other modes shrink by e^-20 before the first look.
    const auto tip = [&](std::size_t i) { return lane(stage.state(i).back().position, 0).x; };
    test::advance(stage, 2 * stage.plan.steps / 3, cost);
    const std::array<double, 2> first{tip(0), tip(1)};
    const double begin = stage.clock.time();
    test::advance(stage, stage.plan.steps, cost);
    std::array<double, 2> square{};
    for (std::size_t i = 0; i < 2; ++i) {
        const double lambda = std::log(tip(i) / first[i]) / (stage.clock.time() - begin);
        square[i] = -lambda * (lambda + damping) / (omega * omega);
    }
    return square;
}

TEST(Buckling, CriticalLoadMeetsClosedFormAtSecondOrder) {
    const double exact = critical_load();
    EXPECT_NEAR(exact / euler, 1, 1e-2) << "a slender rod: near Euler's load";
    test::ErrorTable table("euler_buckling");
    for (const long n : {10, 20, 40, 80}) {
        double load = exact, dt = 0;
        test::Cost cost;
        for (const double width : {2e-2, 1e-3}) { // secant, then a narrower one about the load found
            const double low = (1 - width) * load, high = (1 + width) * load;
            const auto [below, above] = stiffness(n, {low, high}, dt, cost);
            EXPECT_GT(below, 0) << "stands at " << 1 - width << " of the load";
            EXPECT_LT(above, 0) << "buckles at " << 1 + width << " of the load";
            load = low + (high - low) * below / (below - above);
        }
        const double order = table.add("critical load", n, dt, std::abs(load / exact - 1), cost);
        if (n > 10) {
            EXPECT_NEAR(order, 2.0, 0.1);
        }
        if (n == 20) {
            EXPECT_LE(std::abs(load / exact - 1), 1e-3);
        }
    }
}

} // namespace
} // namespace skein
