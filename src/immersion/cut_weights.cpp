#include "immersion/cut_weights.hpp"

#include "fluid/fluid_grid.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace skein {

namespace {

/// Means over a face of max(0, s) and of its square over two, where s = distance + y + z, |y| <= a, |z| <= b.
/// theory.md (137)
class FaceMeans {
public:
    FaceMeans(double a, double b) : a_(std::max(a, b)), b_(std::min(a, b)), flat_(b_ <= thin * a_) {}

    double of_distance(double s) const {
        if (s >= a_ + b_) return s;
        if (s <= -a_ - b_) return 0;
        if (flat_) return (power<2>(s + a_) - power<2>(s - a_)) / (4 * a_);
        return corners<3>(s) / (24 * a_ * b_);
    }
    /// Share of the face where s is above 0.
    double of_sign(double s) const {
        if (s >= a_ + b_) return 1;
        if (s <= -a_ - b_) return 0;
        if (flat_) return std::min(std::max(s + a_, 0.0) / (2 * a_), 1.0);
        return corners<2>(s) / (8 * a_ * b_);
    }
    double of_square(double s) const {
        if (s >= a_ + b_) return 0.5 * s * s + (a_ * a_ + b_ * b_) / 6;
        if (s <= -a_ - b_) return 0;
        if (flat_) return (power<3>(s + a_) - power<3>(s - a_)) / (12 * a_);
        return corners<4>(s) / (96 * a_ * b_);
    }

private:
    static constexpr double thin = 1e-3; // ratio of b and a below which differences of powers would cancel

    template <int n> static double power(double x) {
        if (x <= 0) return 0;
        const double square = x * x;
        return n == 2 ? square : n == 3 ? square * x : square * square;
    }
    template <int n> double corners(double s) const {
        return (power<n>(s + a_ + b_) - power<n>(s + a_ - b_)) - (power<n>(s - a_ + b_) - power<n>(s - a_ - b_));
    }

    double a_, b_;
    bool flat_;
};

} // namespace

CutWeights cut_weights(double distance, const Vec3d& normal, int component, const std::array<CutLines, 3>& lines) {
    const auto half_width = [&](int d) { return 0.5 * std::abs(component_of(normal, d % 3)); };
    const FaceMeans mean(half_width(component + 1), half_width(component + 2));
    CutWeights weights{.open = mean.of_distance(distance)};
    if (weights.closed()) return weights;
    weights.closed_share = 1 - mean.of_sign(distance);
    const double f = weights.open, q = mean.of_square(distance);
    constexpr double along_surface = 1e-3; // cosine below which both neighbours are about as far from the surface
    for (int d = 0; d < 3; ++d) {
        if (nth(lines, d) == CutLines::none) continue;
        const double slope = std::abs(component_of(normal, d)), f_ahead = mean.of_distance(distance + slope),
                     f_behind = mean.of_distance(distance - slope);
        double more = 0; // theory.md (138)
        if (nth(lines, d) == CutLines::quadratic && slope > along_surface)
            more = (slope * slope - (mean.of_square(distance - slope) - q * f_behind / f)) /
                       (mean.of_square(distance + slope) - q * f_ahead / f) -
                   1;
        nth(weights.ahead, d) = more;
        weights.excess += more + ((f_ahead - f) * (1 + more) + (f_behind - f)) / f;
    }
    return weights;
}

} // namespace skein
