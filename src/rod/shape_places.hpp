// Places of nodes, elements and vertices along a rod, and interpolation between them.
#pragma once

#include "skein/core/index.hpp"
#include "skein/core/vec3.hpp"
#include "skein/rod/rod_spec.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace skein {

/// Places of nodes 0 to n from the start, over the length.
std::vector<double> nodes_of(const Shape& shape);
/// Places of the middles of elements, over the length.
std::vector<double> middles_of(const Shape& shape);
/// Places of inner vertices, over the length; in a ring the last one is where it closes.
std::vector<double> vertices_of(const Shape& shape);

/// Linear interpolation to places `to`, between values at rising places, round a ring. Beyond the first and last place
/// the nearest piece is extended.
template <class T> std::vector<T> between(const std::vector<double>& at, const std::vector<T>& value,
                                          const std::vector<double>& to, bool ring) {
    const std::size_t n = at.size();
    std::vector<T> out;
    for (const double s : to) {
        std::size_t after = to_index(std::upper_bound(at.begin(), at.end(), s) - at.begin());
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

} // namespace skein
