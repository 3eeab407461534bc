// Axial and torsional standing waves of a rod held at one end, second mode, k = 3 pi/(2L):
//   u = a sin(k s) cos(W t),  W = c k,   c^2 = E/rho (displacement of nodes) or G/rho (turn of elements about d3)
#pragma once

#include "support/relaxation.hpp"

#include <numbers>

namespace skein::test {

enum class Wave { axial, torsional };

struct StandingWave {
    Wave wave;
    long n;

    static constexpr double k = 1.5 * std::numbers::pi; // L = rho = E = 1
    static constexpr double amplitude =
        1e-8; ///< m or rad; strain of 5e-8, whose share in the frequency is far below the errors here
    static constexpr double radius = 0.2; ///< thick, so that the axial limit governs the step

    double speed() const { return wave == Wave::axial ? 1 : std::sqrt(1.0 / 3); }
    double frequency() const { return speed() * k; }
    SceneSpec scene(double duration) const {
        SceneSpec scene;
        scene.rods = {clamped_unit_rod(n, radius)};
        scene.time = {.duration = duration};
        return scene;
    }
    /// Nodes or elements.
    std::size_t count() const { return static_cast<std::size_t>(n) + (wave == Wave::axial ? 1 : 0); }
    /// Of the i-th, over the amplitude.
    double shape(std::size_t i) const {
        return std::sin(k / static_cast<double>(n) * (static_cast<double>(i) + (wave == Wave::torsional ? 0.5 : 0)));
    }
    void displace(Stage& stage) const {
        auto state = stage.state(0);
        for (std::size_t i = 0; i < count(); ++i) {
            if (wave == Wave::axial)
                set_lane(state[i].position, 0, lane(state[i].position, 0) + Vec3d{0, 0, amplitude * shape(i)});
            else set_lane(state[i].director, 0, rotation({0, 0, amplitude * shape(i)}) * lane(state[i].director, 0));
        }
        stage.rods->import_rod(0, state);
    }
    /// u of the i-th, over the amplitude.
    double displacement(const std::vector<Slot<1>>& state, std::size_t i) const {
        if (wave == Wave::axial)
            return (lane(state[i].position, 0).z - static_cast<double>(i) / static_cast<double>(n)) / amplitude;
        const Vec3d d1 = frame(state[i]).d1;
        return std::atan2(d1.y, d1.x) / amplitude;
    }
};

} // namespace skein::test
