#include "rod/shape_places.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <cstddef>

namespace skein {

std::vector<double> nodes_of(const Shape& shape) {
    std::vector<double> at{0};
    for (long i = 0; i < shape.elements; ++i)
        at.push_back(at.back() + (shape.length_profile.empty() ? 1 : nth(shape.length_profile, i)));
    for (double& s : at) s /= at.back();
    return at;
}

std::vector<double> middles_of(const Shape& shape) {
    const auto node = nodes_of(shape);
    std::vector<double> at;
    for (std::size_t i = 0; i + 1 < node.size(); ++i) at.push_back(0.5 * (node[i] + node[i + 1]));
    return at;
}

std::vector<double> vertices_of(const Shape& shape) {
    const auto node = nodes_of(shape);
    return {node.begin() + 1, node.end() - (shape.closed ? 0 : 1)};
}

namespace {

template <class T> std::vector<T> values_between(const std::vector<double>& at, const std::vector<T>& value,
                                                 const std::vector<double>& to, bool ring) {
    const std::size_t n = at.size();
    std::vector<T> out;
    for (const double s : to) {
        std::size_t after = static_cast<std::size_t>(std::upper_bound(at.begin(), at.end(), s) - at.begin());
        if (n == 1) {
            out.push_back(value[0]);
            continue;
        }
        double from = 0, till = 0;
        std::size_t a = 0, b = 0;
        if (ring && (after == 0 || after == n)) {
            a = n - 1;
            b = 0;
            from = at[a] - (after == 0 ? 1 : 0);
            till = at[b] + (after == 0 ? 0 : 1);
        } else {
            after = std::clamp<std::size_t>(after, 1, n - 1);
            a = after - 1;
            b = after;
            from = at[a];
            till = at[b];
        }
        const double share = (s - from) / (till - from);
        out.push_back(share == 0 ? value[a] : share == 1 ? value[b] : (1 - share) * value[a] + share * value[b]);
    }
    return out;
}

} // namespace

std::vector<double> between(const std::vector<double>& at, const std::vector<double>& value,
                            const std::vector<double>& to, bool ring) {
    return values_between(at, value, to, ring);
}
std::vector<Vec3d> between(const std::vector<double>& at, const std::vector<Vec3d>& value,
                           const std::vector<double>& to, bool ring) {
    return values_between(at, value, to, ring);
}

} // namespace skein
