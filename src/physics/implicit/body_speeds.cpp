#include "physics/implicit/body_speeds.hpp"

#include "rod/body_shape.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace skein {

FastestNode fastest_node(const Rods& rods, std::span<const RodGroup> groups) {
    FastestNode fastest;
    std::vector<Slot<1>> state;
    const auto local = rods.local();
    for (std::size_t i = 0; i < local.size(); ++i) {
        const RodGroup& group = nth(groups, local[i].group);
        state.resize(to_index(group.slots()));
        rods.export_rod(i, state);
        for (const Slot<1>& s : state) {
            const double turning = group.strained() ? 0 : group.body()->reach * norm(lane(s.spin, 0));
            const double speed = norm(lane(s.velocity, 0)) + turning;
            if (speed > fastest.speed) fastest = {speed, local[i].gid};
        }
    }
    return fastest;
}

double fastest_wall(const Walls* walls) {
    double most = 0;
    for (std::size_t w = 0; walls && w < walls->count(); ++w) {
        const Wall& wall = walls->wall[w];
        const Vec3d& now = wall.servo.drives() ? walls->state[w].velocity : wall.velocity;
        if (wall.stands) most = std::max(most, norm(now));
    }
    return most;
}

double thinnest(const RodGroup& group) {
    double least = HUGE_VAL;
    if (group.strained())
        for_each_kind(group, [&](const RodGroup& kind, double) {
            for (const ElementConstants& e : kind.element) least = std::min(least, e.radius);
        });
    else
        for (const BodyShape::Part& part : group.body()->part) least = std::min(least, part.radius);
    return least;
}

} // namespace skein
