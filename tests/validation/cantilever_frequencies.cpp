// Frequencies of a clamped rod against the roots of Timoshenko's frequency determinant (support/timoshenko_beam.hpp).
// Each rod starts at rest in one exact mode shape. Its projection on that shape is a cosine up to the square of the
// shape's own error, so three samples (lag T) give the frequency: a(t+T) + a(t-T) = 2 cos(W T) a(t). The share of the
// step is known in closed form for linear motion, sin(W dt/2) = (dt/2) W_n, and taken out: what is left is the error in
// space.
#include "support/cantilever_modes.hpp"
#include "validation/study.hpp"

#include <numbers>

namespace skein {
namespace {

constexpr double length = 1, radius = 0.05, density = 1, youngs = 1;
constexpr int modes = 3;
constexpr double amplitude = 1e-4; ///< of the tip over the length: squared, the share of nonlinear terms

constexpr test::TimoshenkoBeam cantilever{length, radius, density, youngs, youngs / 3};

/// Frequencies in space of a rod of n elements, rad/s.
std::array<double, modes> measured(const std::array<double, modes>& exact, long n, double& dt, test::Cost& cost) {
    SceneSpec scene = test::clamped_beam(cantilever, n, 6 * std::numbers::pi / exact[0]);
    scene.rods[0].placement = {.kind = PlacementKind::line, .counts = {modes}, .spacing = {1}};
    test::Stage stage(scene);
    dt = stage.plan.dt;

    std::vector<test::ModeShape> shape;
    for (std::size_t m = 0; m < modes; ++m) {
        shape.emplace_back(cantilever, exact[m], n);
        shape[m].displace(stage, m, amplitude * length);
    }

    const double last_period = 2 * std::numbers::pi / exact[modes - 1];
    const auto stride = static_cast<std::int64_t>(last_period / 12 / dt);
    std::array<std::vector<double>, modes> sample;
    for (std::int64_t step = 0; step <= stage.plan.steps; step += stride) {
        test::advance(stage, step, cost);
        for (std::size_t m = 0; m < modes; ++m) sample[m].push_back(shape[m].projection(stage, m));
    }
    std::array<double, modes> frequency{};
    for (std::size_t m = 0; m < modes; ++m) {
        const std::vector<double>& a = sample[m];
        const double spacing = dt * static_cast<double>(stride);
        const auto lag = static_cast<std::size_t>(std::llround(2 * std::numbers::pi / exact[m] / 6 / spacing));
        double product = 0, square = 0;
        for (std::size_t i = lag; i + lag < a.size(); ++i) {
            product += a[i] * (a[i - lag] + a[i + lag]);
            square += 2 * a[i] * a[i];
        }
        const double stepped = std::acos(product / square) / (spacing * static_cast<double>(lag));
        frequency[m] = 2 / dt * std::sin(0.5 * stepped * dt);
    }
    return frequency;
}

TEST(CantileverFrequencies, MeetTimoshenkosRootsAtSecondOrder) {
    const auto exact = cantilever.frequencies<modes>();
    const double slender = std::sqrt(youngs * 0.25 * radius * radius / density) / (length * length);
    EXPECT_NEAR(exact[0] / slender, 3.516, 0.05) << "near the slender rod";
    constexpr double bar[] = {2.5e-3, 1.2e-2};
    test::ErrorTable table("cantilever_frequencies");
    for (const long n : {10, 20, 40, 80}) {
        double dt = 0;
        test::Cost cost;
        const auto frequency = measured(exact, n, dt, cost);
        for (std::size_t m = 0; m < modes; ++m) {
            const double error = std::abs(frequency[m] / exact[m] - 1);
            const double order = table.add("mode " + std::to_string(m), n, dt, error, cost);
            if (n == 20 && m < std::size(bar)) {
                EXPECT_LE(error, bar[m]) << "mode " << m;
            }
            if (n >= 40) {
                EXPECT_NEAR(order, 2.0, 0.1) << "mode " << m;
            }
        }
    }
}

} // namespace
} // namespace skein
