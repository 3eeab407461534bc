#include "rod_self_contact.hpp"

#include <cmath>
#include <numbers>

namespace skein::replay {

RodSelfContact::RodSelfContact(const Entry& e) : stiffness(e["k"].number()), damping(e["nu"].number()) {
    e.expect_keys({"kind", "system", "other", "k", "nu"});
}

void RodSelfContact::add(Rod& rod) const {
    const auto segments = segments_of(rod);
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const Segment& s = segments[i];
        const long skip = static_cast<long>(1 + std::ceil(0.8 * std::numbers::pi * s.radius / s.length));
        for (long below = static_cast<long>(i) - skip; below >= 0; --below) {
            const auto j = static_cast<std::size_t>(below);
            const Segment& t = segments[j];
            const double radii = s.radius + t.radius;
            if (norm(s.start - t.start) >= radii + (s.length + t.length)) continue;
            const Vec3d apart = nearest(s.start, s.edge, t.start, t.edge).gap;
            const double distance = norm(apart), overlap = radii - distance;
            if (!(overlap > 0)) continue;
            const Vec3d d = (1 / distance) * apart;
            const double force =
                0.5 * (stiffness * overlap + damping * dot(mean_velocity(rod, i) - mean_velocity(rod, j), d));
            add_to_element(rod, i, -force * d);
            add_to_element(rod, j, force * d);
        }
    }
}

} // namespace skein::replay
