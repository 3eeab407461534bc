#include "physics/loads/plane_numbers.hpp"

#include "loads/gravity.hpp"
#include "loads/plane_friction.hpp"
#include "physics/group_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace skein {

namespace {

/// Size of all gravity on a group, m/s^2.
double gravity_on(const SceneSpec& scene, const RodGroup& group) {
    Vec3d sum{0, 0, 0};
    for (const LoadSpec& load : scene.loads)
        if (const auto* gravity = load.load.get_if<Gravity>(); gravity && names_group(load.rods, group.name()))
            sum = sum + gravity->acceleration;
    return norm(sum);
}

} // namespace

SceneSpec with_plane_numbers(SceneSpec scene, std::span<const RodGroup> groups) {
    for (std::size_t i = 0; i < scene.loads.size(); ++i) {
        auto* plane = scene.loads[i].load.get_if<PlaneFriction>();
        if (!plane) continue;
        double radius = HUGE_VAL, speed = HUGE_VAL;
        for (const RodGroup& group : groups) {
            if (!names_group(scene.loads[i].rods, group.name())) continue;
            radius = std::min(radius, PlaneFriction::least_radius(group));
            speed = std::min(speed, PlaneFriction::speed_of(group, gravity_on(scene, group)));
        }
        if (std::isfinite(radius)) plane->choose(radius, speed);
    }
    return scene;
}

std::vector<std::string> plane_doubts(const SceneSpec& scene, std::span<const RodGroup> groups) {
    std::vector<std::string> found;
    for (std::size_t i = 0; i < scene.loads.size(); ++i) {
        const auto* plane = scene.loads[i].load.get_if<PlaneFriction>();
        for (const RodGroup& group : groups) {
            if (!plane || !names_group(scene.loads[i].rods, group.name())) continue;
            const double radius = PlaneFriction::least_radius(group), share = plane->tolerance / radius;
            if (share > PlaneFriction::most_tolerance)
                found.push_back(
                    fmt::format("load.{}.tolerance = {:g} m is {:.2g} radii of '{}': elements up to that far above the "
                                "plane are held and rubbed as if they lay on it; tolerance = {:.2g} would do, or "
                                "\"auto\"",
                                i, plane->tolerance, share, group.name(), PlaneFriction::touching_share * radius));
        }
    }
    return found;
}

} // namespace skein
