#include "core/nearest.hpp"
#include "physics/contact/law_check.hpp"
#include "physics/group_names.hpp"
#include "physics/scene_spec.hpp"
#include "physics/table_objections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace skein {

namespace {

/// A servo watches a wall, or a side of a box, that stands as long as its own.
void watched(const SceneSpec& scene, const Wall& driven, Objections& objections) {
    const std::string& name = driven.servo.watch;
    std::vector<std::string> names;
    const Wall* found = nullptr;
    for (const Wall& wall : scene.walls) {
        const std::size_t before = names.size();
        if (wall.kind != WallKind::box) names.push_back(wall.name);
        else
            for (const std::string_view side : box_side_names)
                if (has_side(wall, side)) names.push_back(fmt::format("{} {}", wall.name, side));
        if (std::find(names.begin() + static_cast<std::ptrdiff_t>(before), names.end(), name) != names.end())
            found = &wall;
    }
    if (found) {
        for (const StageSpec& stage : scene.stages)
            if (acts_in(driven.stages, stage) && !acts_in(found->stages, stage))
                objections.add("servo.watch",
                               fmt::format("'{}' does not stand in stage '{}', in which its stress decides: add the "
                                           "stage to its 'stages', or remove it from the 'stages' of '{}'",
                                           name, stage.name, driven.name));
        return;
    }
    const std::vector<std::string_view> known(names.begin(), names.end());
    objections.add("servo.watch",
                   fmt::format("there is no wall '{}' to watch{}", name, suggestion(name, known, "the walls are")));
}

} // namespace

void WallTables::check(const SceneSpec& scene, Objections& objections) {
    for (std::size_t i = 0; i < scene.walls.size(); ++i) {
        const Wall& wall = scene.walls[i];
        TableObjections table(objections, fmt::format("wall.{}", i));
        if (!good_name(wall.name))
            table.add("name", fmt::format("'{}' cannot name a wall: use letters, digits, _ and -", wall.name));
        for (std::size_t j = 0; j < i; ++j)
            if (scene.walls[j].name == wall.name) table.add("name", fmt::format("two walls are named '{}'", wall.name));
        acted_on(scene, wall.rods, table);
        check_law(wall.law, ContactSpec{}.overlap, table);
        if (wall.servo.drives()) watched(scene, wall, table);
    }
    if (!scene.walls.empty() && kicks_backwards(scene.time.integrator))
        objections.add("wall.0", "walls need integrator = \"verlet\": the kicks of \"pefrl\" go backwards too");
}

} // namespace skein
