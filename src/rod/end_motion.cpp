#include "skein/rod/end_motion.hpp"

#include "formula/formula.hpp"
#include "formula/vector_of_time.hpp"
#include "skein/core/index.hpp"
#include "skein/core/objections.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace skein {

void EndMotion::fields(FieldVisitor& f) {
    f.visit({.name = "times", .unit = "s", .text = "times of the tables' entries, rising", .at_least = 0}, times);
    f.visit({.name = "translation",
             .unit = "m",
             .text = "displacement of the end at `times`, lab frame; in an assembly, its axes"},
            translation);
    f.visit({.name = "rotation",
             .unit = "rad",
             .text = "rotation vector of the wall at `times`, lab frame; in an assembly, its axes"},
            rotation);
    f.visit({.name = "smooth",
             .text = "true starts and stops at rest between entries (3 s^2 - 2 s^3), false moves linearly"},
            smooth);
    f.visit({.name = "amplitude", .unit = "m", .text = "sinusoidal displacement, lab frame; in an assembly, its axes"},
            amplitude);
    f.visit({.name = "rotation_amplitude",
             .unit = "rad",
             .text = "sinusoidal rotation vector, lab frame; in an assembly, its axes"},
            rotation_amplitude);
    f.visit({.name = "period", .unit = "s", .text = "period of the sinusoids", .at_least = 0}, period);
    f.visit({.name = "phase", .unit = "rad", .text = "phase of the sinusoids at t = 0"}, phase);
    f.visit({.name = "translation_formula",
             .unit = "m",
             .text = "three formulas of `t`: displacement of the end, lab frame; in an assembly, its axes"},
            translation_formula);
    f.visit({.name = "rotation_formula",
             .unit = "rad",
             .text = "three formulas of `t`: rotation vector of the wall, lab frame; in an assembly, its axes"},
            rotation_formula);
}

void EndMotion::use(const FormulaScope& names) {
    const auto read = [&](const std::vector<std::string>& texts, const char* unit) {
        return std::shared_ptr<const VectorOfTime>(texts.empty() ? nullptr : new VectorOfTime(names, texts, unit));
    };
    formula_u = read(translation_formula, "m");
    formula_r = read(rotation_formula, "rad");
}

void EndMotion::check_formulas(const Vec3d& free, Objections& objections) const {
    if (formula_u) add_faults("translation_formula", formula_u->faults(), objections);
    if (formula_r) add_faults("rotation_formula", formula_r->faults(), objections);
    const double slides[] = {free.x, free.y, free.z};
    for (std::size_t i = 0; formula_u && i < 3; ++i)
        if (slides[i] > 0 && !formula_u->vanishes(i))
            objections.add_within(
                fmt::format("translation_formula.{}", i), 0, translation_formula[i].size(),
                fmt::format("'translation_formula' moves the end along {}, in which it is free to slide: write \"0\"",
                            "xyz"[i]));
}

EndMotion::Point EndMotion::at(double time, const std::vector<Vec3d>& table, const Vec3d& swing,
                               const VectorOfTime* formula) const {
    Point p;
    if (!table.empty()) {
        const std::size_t next = to_index(std::upper_bound(times.begin(), times.end(), time) - times.begin());
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
    if (formula) {
        const VectorOfTime::Point written = (*formula)(time);
        p.value += written.value;
        p.rate += written.rate;
    }
    return p;
}

} // namespace skein
