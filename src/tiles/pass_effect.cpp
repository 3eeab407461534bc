#include "tiles/pass_effect.hpp"
#include "skein/core/index.hpp"

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

bool finite(const Vec3d& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

bool finite(const Slot<1>& s) {
    return finite(lane(s.position, 0)) && finite(lane(s.velocity, 0)) &&
           std::isfinite(dot(s.director, s.director)[0]) && finite(lane(s.spin, 0));
}

} // namespace

PassWatch::PassWatch(const RodGroup& group) : group_(group) { begin(); }

void PassWatch::begin() {
    force_.assign(to_index(group_.slots()), Vec3d{0, 0, 0});
    couple_ = force_;
}

void PassWatch::compare(PassEffect& effect, std::span<const Slot<1>> state, std::span<const Vec3d> force,
                        std::span<const Vec3d> couple, double dt, bool adds) {
    const auto consider = [&](int k, bool turns, double load, double share) {
        if (share > effect.share) {
            effect.at = k;
            effect.turns = turns;
            effect.load = load;
            effect.share = share;
        }
    };
    for (int k = 0; k < group_.slots(); ++k) {
        const std::size_t i = to_index(k);
        const Vec3d more_force = force[i] - force_[i], more_couple = couple[i] - couple_[i];
        force_[i] = force[i];
        couple_[i] = couple[i];
        if (!effect.finite) continue;
        if (!finite(state[i]) || !finite(force[i]) || !finite(couple[i])) {
            effect.finite = false;
            effect.at = k;
            continue;
        }
        if (!adds) continue;
        const ElementConstants& e = group_.element[std::min(i, group_.element.size() - 1)];
        if (const double mass = group_.node_mass[i]; mass > 0)
            consider(k, false, norm(more_force), dt * dt * norm(more_force) / (mass * e.rest_length));
        if (k < group_.elements() && !group_.holds_element(k))
            consider(k, true, norm(more_couple), dt * dt * norm(scale(e.inv_inertia, more_couple)));
    }
}

} // namespace skein
