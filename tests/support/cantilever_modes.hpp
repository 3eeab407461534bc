// Clamped rods of small deflection let go in one exact mode (support/timoshenko_beam.hpp), and how much of that mode
// they hold later.
#pragma once

#include "support/relaxation.hpp"
#include "support/timoshenko_beam.hpp"

namespace skein::test {

/// Undamped and unloaded, for `duration` (s).
inline SceneSpec clamped_beam(const TimoshenkoBeam& beam, long n, double duration) {
    SceneSpec scene;
    scene.rods = {clamped_rod(beam, n)};
    scene.time = {.duration = duration};
    return scene;
}

struct ModeShape {
    std::vector<double> w, theta; ///< at nodes; at middles of elements

    ModeShape(const TimoshenkoBeam& beam, double frequency, long n) {
        const double l = beam.length / static_cast<double>(n);
        for (long k = 0; k <= n; ++k) w.push_back(beam.shape(frequency, l * static_cast<double>(k))[0]);
        for (long k = 0; k < n; ++k) theta.push_back(beam.shape(frequency, l * (static_cast<double>(k) + 0.5))[1]);
    }

    /// Adds the shape to rod i, its tip moving by `amplitude` (m).
    void displace(Stage& stage, std::size_t i, double amplitude) const {
        auto state = stage.state(i);
        for (std::size_t k = 0; k < state.size(); ++k) {
            set_lane(state[k].position, 0, lane(state[k].position, 0) + Vec3d{amplitude * w[k], 0, 0});
            if (k + 1 < state.size())
                set_lane(state[k].director, 0, rotation({0, amplitude * theta[k], 0}) * lane(state[k].director, 0));
        }
        stage.rods->import_rod(i, state);
    }
    /// Of rod i of the first group on the shape, weighed with mass and inertia: a cosine in time.
    double projection(const Stage& stage, std::size_t i) const {
        const RodGroup& group = stage.groups[0];
        const auto state = stage.state(i);
        const double x0 = group.origin(stage.rods->local()[i].index).x;
        double sum = 0;
        for (std::size_t k = 0; k < state.size(); ++k) {
            sum += group.node_mass[k] * w[k] * (lane(state[k].position, 0).x - x0);
            if (k + 1 < state.size()) sum += group.element[k].inertia.y * theta[k] * std::asin(frame(state[k]).d3.x);
        }
        return sum;
    }
};

} // namespace skein::test
