#include "immersion/element_cubes.hpp"

#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace skein {

void ElementCubes::fill(std::span<const Vec3d> middle, std::span<const double> cover, double near) {
    const std::size_t n = middle.size();
    Vec3d upper = lower_ = middle[0];
    for (std::size_t k = 0; k < n; ++k) {
        const double reach = cover[k] + near;
        const Vec3d out{reach, reach, reach}, from = middle[k] - out, to = middle[k] + out;
        lower_ = {std::min(lower_.x, from.x), std::min(lower_.y, from.y), std::min(lower_.z, from.z)};
        upper = {std::max(upper.x, to.x), std::max(upper.y, to.y), std::max(upper.z, to.z)};
    }
    const Vec3d extent = upper - lower_;
    constexpr double most_of_each = 64; // cubes for an element
    size_ = std::max(0.5 * near, std::cbrt(extent.x * extent.y * extent.z / (most_of_each * static_cast<double>(n))));
    double cubes = 1;
    for (int d = 0; d < 3; ++d) cubes *= 1 + component_of(extent, d) / size_;
    count_ = {};
    constexpr double most_cubes = 1e3; // for an element
    if (!(cubes < most_cubes * static_cast<double>(n + most_of_each))) return;
    for (int d = 0; d < 3; ++d) nth(count_, d) = 1 + static_cast<int>(component_of(extent, d) / size_);
    const auto for_cubes = [&](auto&& body) {
        for (std::size_t k = 0; k < n; ++k) {
            std::array<int, 3> from{}, to{};
            for (int d = 0; d < 3; ++d) {
                const double at = component_of(middle[k] - lower_, d), reach = cover[k] + near;
                nth(from, d) = std::max(0, static_cast<int>((at - reach) / size_));
                nth(to, d) = std::min(nth(count_, d) - 1, static_cast<int>((at + reach) / size_));
            }
            for (int z = from[2]; z <= to[2]; ++z)
                for (int y = from[1]; y <= to[1]; ++y)
                    for (int x = from[0]; x <= to[0]; ++x) body(k, to_index(x + count_[0] * (y + count_[1] * z)));
        }
    };
    first_.assign(to_index(count_[0] * count_[1] * count_[2]) + 1, 0);
    for_cubes([&](std::size_t, std::size_t cube) { ++first_[cube + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    element_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for_cubes([&](std::size_t k, std::size_t cube) { element_[next[cube]++] = static_cast<std::uint32_t>(k); });
}

std::span<const std::uint32_t> ElementCubes::at(const Vec3d& place) const {
    std::size_t cube = 0;
    for (int d = 2; d >= 0; --d) {
        const double number = component_of(place - lower_, d) / size_;
        const int count = nth(count_, d);
        if (!(number >= 0 && number < count)) return {};
        cube = cube * to_index(count) + static_cast<std::size_t>(number);
    }
    return std::span(element_).subspan(first_[cube], first_[cube + 1] - first_[cube]);
}

} // namespace skein
