#include "plan/law_differences.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

std::optional<std::string> law_differences(const RodGroup& group) {
    constexpr double small = 0.05; // of r kappa: below, laws differ by less than 0.1 % of the length
    if (!group.strained() || group.heterogeneous() || group.law() == Law::elastica) return std::nullopt;
    const Shape& s = group.spec().shape;
    double most = 0, by_bending = 0, by_twist = 0, bent = 0, twisted = 0;
    for (std::size_t k = 0; k < group.voronoi.size(); ++k) {
        const VoronoiConstants& c = group.voronoi[k];
        const ElementConstants& e = group.element[k];
        const auto look = [&](const Vec3d& kappa) {
            const double q_b = c.stiffness.x * kappa.x * kappa.x + c.stiffness.y * kappa.y * kappa.y,
                         q_t = c.stiffness.z * kappa.z * kappa.z;
            if (!(q_b + q_t > most)) return;
            most = q_b + q_t;
            by_bending = q_b / e.stiffness.z;
            by_twist = q_t / e.stiffness.z;
            bent = 2 * std::sqrt(by_bending); // r kappa of a circle
            twisted = e.radius * std::abs(kappa.z);
        };
        look(c.rest_curvature);
        if (!s.start_curvature_profile.empty()) look(s.start_curvature_profile[k]);
        else if (s.start_curvature) look(*s.start_curvature);
    }
    if (!(std::max(bent, twisted) > small)) return std::nullopt;
    return fmt::format(
        "r kappa reaches {:.2g} in bending and {:.2g} in twist; from straight to that a free rod gets longer by {:.2g} "
        "% "
        "with \"incompressible\", {:.2g} % with \"neo_hookean\" and not at all with \"linear\": theory.md (11a)",
        bent, twisted, 150 * (by_bending + by_twist), 50 * (3 * by_bending + by_twist));
}

} // namespace skein
