// Walls in the plan of a run.
#pragma once

#include "contact/wall.hpp"

#include <vector>

namespace skein {

struct WallPlan {
    std::vector<Wall> walls; ///< planes, tubes and balls: boxes are taken apart
};

} // namespace skein
