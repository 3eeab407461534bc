#include "mechanics/step_watch.hpp"

#include "core/share_text.hpp"
#include "mechanics/present_eigenvalues.hpp"
#include "skein/core/index.hpp"

#include <fmt/format.h>

namespace skein {

bool StepWatch::restrains(const RodGroup& group) const {
    return dt > 0 && to_index(group.id()) < acted_on.size() && nth(acted_on, group.id()) != 0;
}

std::string unresolved_motion(const RodGroup& group, std::span<const Slot<1>> state, const StepWatch& watch) {
    if (!watch.restrains(group)) return {};
    const double speed = norm(lane(state[0].velocity, 0)), spin = norm(lane(state[0].spin, 0));
    if (speed > watch.most_speed(group))
        return fmt::format("its velocity of {:.4g} m/s moves it by {:.3g} of its size within a step", speed,
                           speed / watch.most_speed(group));
    if (spin > watch.most_spin())
        return fmt::format("its angular velocity of {:.4g} rad/s turns it by {:.3g} rad within a step", spin,
                           spin * watch.dt);
    return {};
}

Tightest tightest(const RodGroup& group, std::span<Slot<1>> state) {
    Tightest found;
    present_eigenvalues(tile_of(group, state), [&](int k, const PresentEigenvalues<Pack<1>>& l) {
        const double all[] = {l.axial[0], l.about_d1[0], l.about_d2[0], l.twist[0]};
        for (std::size_t mode = 0; mode < std::size(all); ++mode)
            if (all[mode] > found.eigenvalue) found = {all[mode], k, limiting_modes[mode]};
    });
    const std::size_t at = to_index(found.element);
    const Vec3d edge = lane(state[at + 1].position, 0) - lane(state[at].position, 0);
    found.dilatation = group.element[at].inv_rest_length * dot(lane(third_director(state[at].director), 0), edge);
    return found;
}

std::string text_of(const Tightest& at, const StepWatch& watch) {
    return fmt::format("element {}: dt = {:.4g} s is {} of the limit {:.4g} s that its present strains leave ({} mode, "
                       "dilatation e = {:.4g})",
                       at.element, watch.dt, share_text(watch.share(at.eigenvalue)), watch.limit(at.eigenvalue),
                       at.mode, at.dilatation);
}

} // namespace skein
