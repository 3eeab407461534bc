#include "skein/rod/end_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein {

void EndMotion::fields(FieldVisitor& f) {
    f.visit({.name = "times", .unit = "s", .text = "times of the tables' entries, rising", .at_least = 0}, times);
    f.visit({.name = "translation", .unit = "m", .text = "displacement of the end at `times`, lab frame"}, translation);
    f.visit({.name = "rotation", .unit = "rad", .text = "rotation vector of the wall at `times`, lab frame"}, rotation);
    f.visit({.name = "smooth", .unit = "", .text = "start and stop at rest between entries (3 s^2 - 2 s^3) instead of linearly"},
            smooth);
    f.visit({.name = "amplitude", .unit = "m", .text = "sinusoidal displacement, lab frame"}, amplitude);
    f.visit({.name = "rotation_amplitude", .unit = "rad", .text = "sinusoidal rotation vector, lab frame"}, rotation_amplitude);
    f.visit({.name = "period", .unit = "s", .text = "of the sinusoids", .at_least = 0}, period);
    f.visit({.name = "phase", .unit = "rad", .text = "of the sinusoids at t = 0"}, phase);
}

EndMotion::Point EndMotion::at(double time, const std::vector<Vec3d>& table, const Vec3d& swing) const {
    Point p;
    if (!table.empty()) {
        const auto next = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
        if (next == 0) {
            p.value = table.front();
        } else if (next == times.size()) {
            p.value = table.back();
        } else {
            const double length = times[next] - times[next - 1], s = (time - times[next - 1]) / length;
            const Vec3d step = table[next] - table[next - 1];
            p.value = table[next - 1] + (smooth ? s * s * (3 - 2 * s) : s) * step;
            p.rate = (smooth ? 6 * s * (1 - s) : 1.0) / length * step;
        }
    }
    if (oscillates(swing)) {
        const double w = 2 * std::numbers::pi / period, angle = w * time + phase;
        p.value += std::sin(angle) * swing;
        p.rate += w * std::cos(angle) * swing;
    }
    return p;
}

} // namespace skein
