#include "immersion/surface.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

double TubeSurface::distance(const Vec3d& place) const {
    const double x = place.x / a_, y = place.y / b_, q = std::sqrt(x * x + y * y);
    if (!(q > 0)) return -std::min(a_, b_);
    return (q - 1) * q / std::sqrt(x * x / (a_ * a_) + y * y / (b_ * b_)); // of second order in the distance
}

} // namespace skein
