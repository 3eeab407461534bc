// Parts of a run outside of the tiles that passes and interactions share.
#pragma once

#include "contact/wall_contacts.hpp"
#include "immersion/fluid_loads.hpp"
#include "neighbourhood/exposure.hpp"
#include "relaxation/relaxation_estimate.hpp"
#include "scene/plan.hpp"

#include <memory>
#include <vector>

namespace skein {

/// Parts that the plan has no use for are absent.
struct Surroundings {
    std::shared_ptr<Exposure> exposure; ///< where rods feel each other
    std::shared_ptr<SlotLoads> loads;   ///< where rods feel each other
    std::shared_ptr<FluidLoads> fluid;  ///< where rods feel a fluid
    std::shared_ptr<Walls> walls;
    std::shared_ptr<RelaxationResidual> residual; ///< where rods relax
    std::vector<std::shared_ptr<const WallContacts>>
        wall_contacts; ///< by group, once the rods are made; null where no wall acts
};

} // namespace skein
