#include "mechanics/kick.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

double phi1(double z) { return z != 0 ? -std::expm1(-z) / z : 1.0; }
double exponential(double z) { return std::exp(-z); }
double midpoint(double z) { return std::max(0.0, (2 - z) / (2 + z)); }
double midpoint_mean(double z) { return z < 2 ? 2 / (2 + z) : 1 / z; }

Vec3d each(const Vec3d& a, double (*f)(double)) { return {f(a.x), f(a.y), f(a.z)}; }

} // namespace

KickConstants::KickConstants(const RodGroup& group, const DampingRates& rates, double h, DampingScheme scheme) {
    double (*const factor)(double) = scheme == DampingScheme::midpoint ? midpoint : exponential;
    double (*const mean)(double) = scheme == DampingScheme::midpoint      ? midpoint_mean
                                   : scheme == DampingScheme::exponential ? phi1
                                                                          : exponential;
    const int n = group.elements();
    node.reserve(group.node_mass.size());
    element.reserve(to_index(n));
    for (int i = 0; i < group.slots(); ++i) {
        const std::size_t at = to_index(i);
        if (group.holds_node(i) || group.node_mass[at] == 0) { // or the copy of a ring's first node
            node.push_back({1, 0});
            continue;
        }
        const double z = rates.none() ? 0.0 : h * rates.node[at];
        node.push_back({factor(z), h / group.node_mass[at] * mean(z)});
    }
    for (int k = 0; k < n; ++k) {
        const std::size_t at = to_index(k);
        const bool held = group.holds_element(k);
        const Vec3d z = rates.none() || held ? Vec3d{0, 0, 0} : h * rates.element[at];
        const Vec3d stretched = rates.follow_stretch() && !held ? h * rates.element_stretched[at] : Vec3d{0, 0, 0};
        const Vec3d& j = group.element[at].inertia;
        const Vec3d impulse = held ? Vec3d{0, 0, 0} : Vec3d{h / j.x, h / j.y, h / j.z};
        element.push_back({each(z, factor), scale(impulse, each(z, mean)), z, stretched, impulse});
    }
}

} // namespace skein
