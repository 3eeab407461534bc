#include "rod_rod_contact.hpp"

#include <algorithm>
#include <cmath>

namespace skein::replay {

namespace {

Vec3d mean_force(const Rod& rod, std::size_t k) {
    const auto total = [&](std::size_t i) { return lane(rod.external[i].force, 0) + lane(rod.internal[i].force, 0); };
    return 0.5 * (total(k) + total(k + 1));
}

} // namespace

RodRodContact::RodRodContact(const Entry& e) : stiffness(e["k"].number()), damping(e["nu"].number()) {
    e.expect_keys({"kind", "system", "other", "k", "nu"});
}

void RodRodContact::add(Rod& a, Rod& b) const {
    const auto of_a = segments_of(a), of_b = segments_of(b);
    const auto reach = [](const std::vector<Segment>& s) { return largest_radius(s) + largest_length(s); };
    if (box_of(a, reach(of_a)).apart_from(box_of(b, reach(of_b)))) return;
    for (std::size_t i = 0; i < of_a.size(); ++i) {
        for (std::size_t j = 0; j < of_b.size(); ++j) {
            const Segment &s = of_a[i], &t = of_b[j];
            const double radii = s.radius + t.radius;
            if (norm(s.start - t.start) >= radii + (s.length + t.length)) continue;
            const Vec3d apart = nearest(s.start, s.edge, t.start, t.edge).gap;
            const double distance = norm(apart), overlap = radii - distance;
            if (overlap < least_overlap) continue;
            const Vec3d d = (1 / distance) * apart;
            double force = std::abs(std::min(dot(mean_force(b, j) - mean_force(a, i), d), 0.0));
            if (overlap > 0)
                force += 0.5 * (stiffness * overlap + damping * dot(mean_velocity(a, i) - mean_velocity(b, j), d));
            add_to_element(a, i, -force * d);
            add_to_element(b, j, force * d);
        }
    }
}

} // namespace skein::replay
