#include "physics/fluid/fitted_fluid.hpp"

#include "rod/body_shape.hpp"
#include "skein/placement/places.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

namespace skein {

std::string unfitted(const SceneSpec& scene) {
    if (scene.rods.empty()) return "margins need rods, which the box is fitted to";
    for (const RodSpec& rods : scene.rods)
        if (rods.placement.kind == PlacementKind::packing || rods.placement.kind == PlacementKind::file ||
            !rods.assembly.empty())
            return fmt::format("margins need rods whose places stand in the scene: rods of '{}' are packed, of a file "
                               "or of an assembly",
                               rods.name);
    return {};
}

FluidSpec fitted_fluid(const SceneSpec& scene) {
    FluidSpec fluid = *scene.fluid;
    if (!fluid.fitted() || !unfitted(scene).empty() || !(fluid.spacing > 0)) return fluid;
    const std::string directory = std::filesystem::path(scene.file).parent_path().string();
    Vec3d least{HUGE_VAL, HUGE_VAL, HUGE_VAL}, most = -least;
    for (const RodSpec& rods : scene.rods) {
        const Places places(rods.placement, rods.source, directory);
        const Quaterniond all = frame_of(rods.placement.tangent, rods.placement.normal);
        const auto take = [&](const Vec3d& place, double reach) {
            const Vec3d around{reach, reach, reach}, below = place - around, above = place + around;
            least = {std::min(least.x, below.x), std::min(least.y, below.y), std::min(least.z, below.z)};
            most = {std::max(most.x, above.x), std::max(most.y, above.y), std::max(most.z, above.z)};
        };
        const std::optional<BodyShape> body = rods.body ? std::optional<BodyShape>(rods) : std::nullopt;
        for (std::int64_t i = 0; i < places.count(); ++i) {
            const Vec3d first = places.origin(i);
            const Quaterniond turn = places.turned() ? all * places.turn(i) : all;
            if (body) take(first + transpose_times(turn, body->centre), body->reach);
            else {
                take(first, 0);
                take(first + rods.shape.length * third_director(places.turned() ? places.turn(i) : all), 0);
            }
        }
    }
    const Vec3d below = fluid.margin_lower ? *fluid.margin_lower : *fluid.margin_upper,
                above = fluid.margin_upper ? *fluid.margin_upper : below;
    const Vec3d lower = least - below, wanted = most + above - lower;
    constexpr double rounding = 1e-9; // of a cell
    const auto cells = [&](double length) {
        return static_cast<long>(
            next_smooth(std::max<std::int64_t>(1, std::llround(std::ceil(length / fluid.spacing - rounding)))));
    };
    fluid.cells = {cells(wanted.x), cells(wanted.y), cells(wanted.z)};
    const Vec3d box = fluid.spacing * Vec3d{static_cast<double>(fluid.cells[0]), static_cast<double>(fluid.cells[1]),
                                            static_cast<double>(fluid.cells[2])};
    fluid.lower = lower - 0.5 * (box - wanted);
    return fluid;
}

} // namespace skein
