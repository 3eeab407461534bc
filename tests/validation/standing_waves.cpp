// Axial and torsional standing waves of a rod held at one end, second mode, k = 3 pi/(2L):
//   u = a sin(k s) cos(W t),  W = c k,   c^2 = E/rho (displacement of nodes) or G/rho (turn of elements about d3)
// With lumped masses and a half cell at the wall sin(k s) is a mode of the discrete rod too, of frequency
//   W_n = (2c/l) sin(k l/2):
// against W a fine step leaves the error in space, against W_n the error in time.
#include "validation/study.hpp"

#include <numbers>

namespace skein {
namespace {

enum class Wave { axial, torsional };

constexpr double k = 1.5 * std::numbers::pi; // L = rho = E = 1
constexpr double amplitude = 1e-8;           ///< strain of 5e-8, whose share in the frequency is far below the errors here
constexpr double radius = 0.2;               ///< thick, so that the axial limit governs the step

double speed(Wave wave) { return wave == Wave::axial ? 1 : std::sqrt(1.0 / 3); }
double discrete_frequency(Wave wave, long n) {
    const double l = 1 / static_cast<double>(n);
    return 2 * speed(wave) / l * std::sin(0.5 * k * l);
}

/// Largest error over nodes (elements) and over two periods in steps of about a fortieth, over the amplitude.
double largest_error(Wave wave, long n, double dt, double frequency, test::Cost& cost) {
    SceneSpec scene;
    scene.rods = {test::clamped_unit_rod(n, radius)};
    scene.time = {.duration = 1, .dt = dt};
    test::Stage stage(scene, 1);

    std::vector<Slot<1>> state = stage.state(0);
    const double l = 1 / static_cast<double>(n);
    const auto shape = [&](std::size_t i) {
        return amplitude * std::sin(k * l * (static_cast<double>(i) + (wave == Wave::torsional ? 0.5 : 0)));
    };
    const std::size_t count = static_cast<std::size_t>(n) + (wave == Wave::axial ? 1 : 0);
    for (std::size_t i = 0; i < count; ++i) {
        if (wave == Wave::axial)
            set_lane(state[i].position, 0, lane(state[i].position, 0) + Vec3d{0, 0, shape(i)});
        else
            set_lane(state[i].director, 0, rotation({0, 0, shape(i)}) * lane(state[i].director, 0));
    }
    stage.rods->import_rod(0, state);

    const double period = 2 * std::numbers::pi / frequency;
    double error = 0;
    for (int sample = 1; sample <= 80; ++sample) {
        test::advance(stage, std::llround(sample * period / 40 / dt), cost);
        const double phase = std::cos(frequency * stage.clock.time());
        state = stage.state(0);
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3d d1 = frame(state[i]).d1;
            const double u =
                wave == Wave::axial ? lane(state[i].position, 0).z - l * static_cast<double>(i) : std::atan2(d1.y, d1.x);
            error = std::max(error, std::abs(u - shape(i) * phase) / amplitude);
        }
    }
    return error;
}

/// Longest step of the wave itself, l/c.
double limit(Wave wave, long n) { return 1 / (static_cast<double>(n) * speed(wave)); }

void study(Wave wave, const char* name) {
    test::ErrorTable table(name);
    for (const long n : {20, 40, 80}) {
        test::Cost cost;
        const double dt = limit(wave, n) / 40;
        const double order = table.add("space", n, dt, largest_error(wave, n, dt, speed(wave) * k, cost), cost);
        if (n > 20) {
            EXPECT_NEAR(order, 2.0, 0.05) << name << ", n = " << n;
        }
    }
    constexpr long n = 20;
    for (const int divisor : {2, 4, 8, 16}) {
        test::Cost cost;
        const double dt = limit(wave, n) / divisor;
        const double order = table.add("time", n, dt, largest_error(wave, n, dt, discrete_frequency(wave, n), cost), cost);
        if (divisor > 2) {
            EXPECT_NEAR(order, 2.0, 0.05) << name << ", limit/" << divisor;
        }
    }
}

TEST(StandingWaves, AxialWaveIsSecondOrderInSpaceAndTime) { study(Wave::axial, "axial_wave"); }
TEST(StandingWaves, TorsionalWaveIsSecondOrderInSpaceAndTime) { study(Wave::torsional, "torsional_wave"); }

} // namespace
} // namespace skein
