#include "joints/cluster_junctions.hpp"

namespace skein {

namespace {

/// w (|a|^2 - a a^T), added.
void add_point(Mat3d& inertia, double w, const Vec3d& a) {
    const double squared = dot(a, a);
    inertia.d1 += w * (Vec3d{squared, 0, 0} - a.x * a);
    inertia.d2 += w * (Vec3d{0, squared, 0} - a.y * a);
    inertia.d3 += w * (Vec3d{0, 0, squared} - a.z * a);
}

} // namespace

std::vector<HubShares> hub_shares(const Hub& hub, const KickGains& gains) {
    std::vector<HubShares> all;
    for (std::size_t length = 0; length < gains.lengths; ++length) {
        HubShares& s = all.emplace_back();
        double sum = 0;
        for (const Hub::Member& m : hub.members) {
            s.share.push_back(hub.held ? 0 : 1 / gains.node(m.group, m.rod, m.node, length));
            sum += s.share.back();
        }
        if (!hub.body) {
            if (!hub.held)
                for (double& share : s.share) share /= sum;
            continue;
        }
        const Vec3d gain = gains.body(hub.members.front().group, length);
        Mat3d inertia{{1 / gain.x, 0, 0}, {0, 1 / gain.y, 0}, {0, 0, 1 / gain.z}};
        for (std::size_t i = 1; i < hub.members.size(); ++i) {
            s.moment += s.share[i] * hub.members[i].arm;
            add_point(inertia, s.share[i], hub.members[i].arm);
        }
        s.inv_weight = 1 / sum;
        add_point(inertia, -1 / sum, s.moment);
        s.inv_inertia = inverse(inertia);
    }
    return all;
}

} // namespace skein
