#include "rod/taper.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace skein {

namespace {

double compliance(double scale) { return 1 / (scale * scale * scale * scale); }

/// Integrals over an element from t = 0 to 1, with the compliance C of its sections: (1 - t) C, t C and t (1 - t)/2 C.
struct Parts {
    double before = 0, after = 0, curved = 0;
};

/// Integrals for a linear scale, at least a third of that of the thicker node. A tip that falls further is not
/// resolved, and its bending is no longer parabolic. Gauss' rule with six points on each half.
Parts integrate(double before, double after) {
    constexpr std::array<double, 3> place = {0.2386191860831969, 0.6612093864662645, 0.9324695142031521},
                                    weight = {0.4679139345726910, 0.3607615730481386, 0.1713244923791704};
    const double least = std::max(before, after) / 3;
    Parts sum;
    for (std::size_t i = 0; i < place.size(); ++i)
        for (const double side : {-place[i], place[i]})
            for (const double begin : {0.0, 0.5}) {
                const double t = begin + 0.25 * (1 + side);
                const double part = 0.25 * weight[i] * compliance(std::max(before + t * (after - before), least));
                sum.before += (1 - t) * part;
                sum.after += t * part;
                sum.curved += 0.5 * t * (1 - t) * part;
            }
    return sum;
}

bool turns_freely(EndKind end) { return end == EndKind::free || end == EndKind::pinned; }

} // namespace

bool SectionScales::uniform() const {
    const auto same = [&](double f) { return f == element[0]; };
    return std::all_of(element.begin(), element.end(), same) && std::all_of(node.begin(), node.end(), same);
}

double mass_share_before(const NodeScales& before, const NodeScales& after) {
    if (before.first == after.first && before.second == after.second) return 0.5;
    const double a = before.first * before.second,
                 b = 0.5 * (before.first * after.second + after.first * before.second), c = after.first * after.second;
    return (3 * a + 2 * b + c) / (4 * (a + b + c));
}

std::vector<double> cell_scales(const SectionScales& scales, EndKind start, EndKind end) {
    const std::size_t n = scales.element.size();
    std::vector<Parts> part(n);
    std::vector<double> weight(n + 1, 0.0);
    for (std::size_t k = 0; k < n; ++k) {
        part[k] = integrate(scales.node[k], scales.node[k + 1]);
        weight[k] += part[k].before;
        weight[k + 1] += part[k].after;
    }
    // A parabola through three nodes is a straight line less t (1 - t)/2 times the second difference. Here the second
    // differences about both nodes of the element share that part. No node gives more than a quarter of its weight to
    // an element that is not beside it; the thinner side gives the rest. Beyond an end that turns freely the rod is
    // mirrored, and the end node has no moment.
    const std::vector<double> linear = weight;
    constexpr double most = 0.25, all = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < n; ++k) {
        const std::size_t outer[] = {k > 0 ? k - 1 : 1, k + 2 <= n ? k + 2 : n - 1};
        const double limit[] = {k <= 1 ? all : most * linear[outer[0]], k + 2 >= n ? all : most * linear[outer[1]]};
        const std::size_t thick = scales.node[k] < scales.node[k + 1] ? 1 : 0, thin = 1 - thick;
        double second[2];
        second[thick] = std::min(0.5 * part[k].curved, limit[thick]);
        second[thin] = std::min(part[k].curved - second[thick], limit[thin]);
        weight[outer[0]] -= second[0];
        weight[k] += 2 * second[0];
        weight[k + 1] -= second[0];
        weight[outer[1]] -= second[1];
        weight[k + 1] += 2 * second[1];
        weight[k] -= second[1];
    }
    std::vector<double> cell(n + 1);
    for (std::size_t i = 0; i <= n; ++i) {
        const bool held = (i <= 1 && !turns_freely(start)) || (i + 1 >= n && !turns_freely(end));
        const bool without_cell = i == 0 || i == n;
        cell[i] = held || without_cell ? scales.node[i] : std::sqrt(std::sqrt(1 / weight[i]));
    }
    return cell;
}

} // namespace skein
