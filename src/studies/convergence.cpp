#include "studies/convergence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace skein {

namespace {

constexpr double least_round_off = 1e-12; ///< differences over values that mean nothing
constexpr double least_alike = 0.9;       ///< cosine between differences of smooth convergence
constexpr double least_second = 1.5, most_second = 2.6, least_order = 0.5, most_order = 4;
/// Margins beyond the Richardson error: of the scheme's own order, and of another one, which more elements may change.
constexpr double margin_second = 0.25, margin_other = 1, margin_time = 0.5;
/// Runs that differ without an order are a few draws of what may be: bounds by them take half as much on top.
constexpr double safety = 1.5;

using Values = std::vector<double>;

double dot(const Values& a, const Values& b) { return std::inner_product(a.begin(), a.end(), b.begin(), 0.0); }

Values combine(double x, std::span<const double> a, double y, std::span<const double> b) {
    Values out(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) out[i] = x * a[i] + y * b[i];
    return out;
}

/// Largest over samples; of the last alone.
struct Norms {
    double most = 0, last = 0;
};
Norms norms(std::span<const double> v, std::size_t components) {
    Norms out;
    for (std::size_t i = 0; i < v.size(); i += components) {
        double sum = 0;
        for (std::size_t k = i; k < i + components; ++k) sum += v[k] * v[k];
        out.last = std::sqrt(sum);
        out.most = std::max(out.most, out.last);
    }
    return out;
}

/// From two values, the second of twice the elements.
Values richardson(const Values& coarse, const Values& fine, double order) {
    const double weight = 1 / (std::exp2(order) - 1);
    return combine(1 + weight, fine, -weight, coarse);
}

/// `nothing`: differences up to this are round-off.
void judge(Convergence& c, const Values& first, const Values& second, double nothing, std::size_t components) {
    c.order = NAN;
    if (norms(first, components).most <= nothing && norms(second, components).most <= nothing) return;
    c.smoothness = Smoothness::rough;
    const double a = dot(first, first), b = dot(second, second), both = dot(first, second);
    if (both <= 0) return;
    c.order = std::log2(both / b);
    if (both < least_alike * std::sqrt(a * b) || c.order < least_order) return;
    c.smoothness = c.order >= least_second && c.order <= most_second ? Smoothness::second : Smoothness::other;
    c.order_used = c.smoothness == Smoothness::second ? 2 : std::min(c.order, most_order);
}

/// Differences that are not smooth are bounded by the run farthest from the given one, and the spread of the last
/// two on top.
void bound(Convergence& c, const LevelValues& levels) {
    const auto apart = [&](std::span<const double> a, std::span<const double> b) {
        return norms(combine(1, a, -1, b), levels.components);
    };
    const std::span<const double> given = levels.space[levels.given];
    const Norms last = apart(levels.space[1], levels.space[2]), half = apart(given, levels.half_step);
    Norms farthest{};
    for (const auto& level : levels.space) {
        const Norms distance = apart(given, level);
        farthest = {std::max(farthest.most, distance.most), std::max(farthest.last, distance.last)};
    }
    c.spread = c.remainder = last.most;
    const auto bar = [&](double space, double time) {
        return Convergence::ErrorBar{safety * (space + last.most), safety * time,
                                     safety * (std::max(space, time) + last.most)};
    };
    c.error_bar = bar(farthest.most, half.most);
    c.error_bar_at_end = bar(farthest.last, half.last);
}

/// Interpolates logarithms; beyond the levels it goes on with the slope of the nearest two, between `least` and `most`.
double along(const std::vector<CostModel::Level>& levels, double elements, double CostModel::Level::*of, double least,
             double most) {
    if (levels.size() == 1) return levels[0].*of;
    std::size_t i = 1;
    while (i + 1 < levels.size() && elements > levels[i].elements) ++i;
    const CostModel::Level &a = levels[i - 1], &b = levels[i];
    const double slope = std::log(b.*of / (a.*of)) / std::log(b.elements / a.elements);
    const bool above = elements > b.elements, within = !above && elements >= a.elements;
    const CostModel::Level& from = above ? b : a;
    return from.*of * std::pow(elements / from.elements, within ? slope : std::clamp(slope, least, most));
}

} // namespace

double distance(std::span<const double> a, std::span<const double> b, std::size_t components) {
    return norms(combine(1, a, -1, b), components).most;
}

double range_of(std::span<const double> values, std::size_t components) {
    double range = 0;
    for (std::size_t i = 0; i < values.size(); i += components)
        range = std::max(range, distance(values.subspan(i, components), values.first(components), components));
    return range;
}

Convergence converge(const LevelValues& levels) {
    const std::size_t components = levels.components;
    const auto& given = levels.space[levels.given];
    const double steps = 1 / (1 - std::exp2(-levels.time_order)); // error of the step over its change by half of it
    const Values time_error = combine(steps, given, -steps, levels.half_step);
    std::array<Values, 3> corrected;
    for (std::size_t k = 0; k < 3; ++k) {
        const double share = std::pow(levels.dt[k] / levels.dt[levels.given], levels.time_order);
        corrected[k] = combine(1, levels.space[k], -share, time_error);
    }
    const Values first = combine(1, corrected[0], -1, corrected[1]),
                 second = combine(1, corrected[1], -1, corrected[2]);
    double magnitude = 0;
    for (const auto& level : levels.space) magnitude = std::max(magnitude, norms(level, components).most);

    Convergence c;
    const double round_off =
        std::max(least_round_off, static_cast<double>(levels.steps) * std::numeric_limits<double>::epsilon());
    judge(c, first, second, round_off * magnitude, components);
    c.spread = norms(second, components).most;
    const Norms time = norms(time_error, components);
    const auto close = [&](Convergence::ErrorBar& bar, double space, double margin, double time_part, double together) {
        bar.space = space + margin;
        bar.time = (1 + margin_time) * time_part;
        bar.total = together + margin + margin_time * time_part;
    };
    if (c.smoothness == Smoothness::rough) {
        bound(c, levels);
        return c;
    }
    c.limit = c.smoothness == Smoothness::exact ? corrected[2] : richardson(corrected[1], corrected[2], c.order_used);
    c.remainder = c.smoothness == Smoothness::exact
                      ? c.spread
                      : distance(c.limit, richardson(corrected[0], corrected[1], c.order_used), components);
    const Norms space = norms(combine(1, corrected[levels.given], -1, c.limit), components);
    const Norms total = norms(combine(1, given, -1, c.limit), components);
    const double margin = c.smoothness == Smoothness::other ? margin_other : margin_second;
    close(c.error_bar, space.most, std::max(margin * space.most, c.remainder), time.most, total.most);
    close(c.error_bar_at_end, space.last, std::max(margin * space.last, c.remainder), time.last, total.last);
    return c;
}

double ErrorModel::at(double times, double dt_share) const {
    return space * std::pow(times, -space_order) + time * std::pow(dt_share, time_order);
}

double CostModel::dt_limit(double elements) const { return along(levels, elements, &Level::dt_limit, -1, 0); }
double CostModel::core_seconds_per_step(double elements) const {
    // With many elements a step takes as long as they are many; with few it takes longer than it should.
    const bool above = !levels.empty() && elements > levels.back().elements;
    return along(levels, elements, &Level::core_seconds_per_step, above ? 1 : 0, 1);
}

std::optional<Choice> cheapest(std::span<const ErrorModel> models, double tolerance, long elements, double dt,
                               const CostModel& cost, double duration) {
    std::optional<Choice> best;
    for (long n = 2; n <= 64 * elements; ++n) {
        const auto times = static_cast<double>(n) / static_cast<double>(elements);
        double step = cost.dt_limit(static_cast<double>(n));
        bool fits = true;
        for (const ErrorModel& m : models) {
            const double left = tolerance - m.at(times, 0);
            fits = fits && left > 0;
            if (fits && m.time > 0) step = std::min(step, dt * std::pow(left / m.time, 1 / m.time_order));
        }
        if (!fits) continue;
        const double seconds = duration / step * cost.core_seconds_per_step(static_cast<double>(n));
        if (!best || seconds < best->core_seconds) best = Choice{n, step, seconds};
    }
    return best;
}

} // namespace skein
