// Axial and torsional standing waves of a rod held at one end (support/standing_wave.hpp). With lumped masses and a
// half cell at the wall sin(k s) is a mode of the discrete rod too, of frequency
//   W_n = (2c/l) sin(k l/2):
// against W a fine step leaves the error in space, against W_n the error in time.
#include "support/standing_wave.hpp"
#include "validation/study.hpp"

namespace skein {
namespace {

using test::StandingWave;
using test::Wave;

double discrete_frequency(const StandingWave& wave) {
    const double l = 1 / static_cast<double>(wave.n);
    return 2 * wave.speed() / l * std::sin(0.5 * wave.k * l);
}

/// Largest error over nodes (elements) and over two periods in steps of about a fortieth, over the amplitude.
double largest_error(const StandingWave& wave, double dt, double frequency, test::Cost& cost) {
    SceneSpec scene = wave.scene(1);
    scene.time.dt = dt;
    test::Stage stage(scene, 1);
    wave.displace(stage);

    const double period = 2 * std::numbers::pi / frequency;
    double error = 0;
    for (int sample = 1; sample <= 80; ++sample) {
        test::advance(stage, std::llround(sample * period / 40 / dt), cost);
        const double phase = std::cos(frequency * stage.clock.time());
        const auto state = stage.state(0);
        for (std::size_t i = 0; i < wave.count(); ++i)
            error = std::max(error, std::abs(wave.displacement(state, i) - wave.shape(i) * phase));
    }
    return error;
}

/// Longest step of the wave itself, l/c.
double limit(const StandingWave& wave) { return 1 / (static_cast<double>(wave.n) * wave.speed()); }

void study(Wave kind, const char* name) {
    test::ErrorTable table(name);
    for (const long n : {20, 40, 80}) {
        const StandingWave wave{kind, n};
        test::Cost cost;
        const double dt = limit(wave) / 40;
        const double order = table.add("space", n, dt, largest_error(wave, dt, wave.frequency(), cost), cost);
        if (n > 20) {
            EXPECT_NEAR(order, 2.0, 0.05) << name << ", n = " << n;
        }
    }
    const StandingWave wave{kind, 20};
    for (const int divisor : {2, 4, 8, 16}) {
        test::Cost cost;
        const double dt = limit(wave) / divisor;
        const double order =
            table.add("time", wave.n, dt, largest_error(wave, dt, discrete_frequency(wave), cost), cost);
        if (divisor > 2) {
            EXPECT_NEAR(order, 2.0, 0.05) << name << ", limit/" << divisor;
        }
    }
}

TEST(StandingWaves, AxialWaveIsSecondOrderInSpaceAndTime) { study(Wave::axial, "axial_wave"); }
TEST(StandingWaves, TorsionalWaveIsSecondOrderInSpaceAndTime) { study(Wave::torsional, "torsional_wave"); }

} // namespace
} // namespace skein
