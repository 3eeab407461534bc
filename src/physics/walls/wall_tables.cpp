#include "physics/walls/wall_tables.hpp"

#include "contact/law_echo.hpp"
#include "physics/key_change.hpp"

#include <algorithm>
#include <array>

namespace skein {

void tidy_echo(nlohmann::json& table, const Wall& wall, const CoreTables&, bool) { tidy_law(table, wall.law); }

bool stays_in_stage(Wall& wall, const ActingStages& acting) {
    wall.stands = acting.now;
    if (!wall.servo.drives() && acting.begin > 0) // at rest until then; a servo drives what stands
        wall.from = std::max(wall.from, acting.begin);
    return true;
}

void go_on_from(const Wall& before, Wall& wall, double time) {
    const Vec3d turned = wall.velocity - before.velocity;
    if (dot(turned, turned) == 0 && wall.from == before.from) return;
    if (before.moves_steadily() && time > before.from) wall.moved = wall.moved + (time - before.from) * before.velocity;
    wall.from = std::max(wall.from, time);
}

bool state_survives(const Wall&, const KeyChange& change) {
    constexpr std::array<std::string_view, 12> geometry = {"",       "name", "kind",  "point", "normal", "axis",
                                                           "radius", "side", "lower", "upper", "open",   "rods"};
    const bool other_wall = std::find(geometry.begin(), geometry.end(), change.part(2)) != geometry.end();
    const bool other_drive = change.part(2) == "servo" && change.last() == "speed"; // it is part of the servo's state
    return !other_wall && !other_drive;
}

} // namespace skein
