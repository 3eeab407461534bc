// Parts of a run outside of the tiles that passes and interactions share.
#pragma once

#include "contact/wall_contacts.hpp"
#include "immersion/fluid_loads.hpp"
#include "implicit/bed_figures.hpp"
#include "joints/joint_list.hpp"
#include "neighbourhood/exposure.hpp"
#include "relaxation/relaxation_estimate.hpp"
#include "tiles/rods.hpp"

#include <memory>
#include <span>
#include <vector>

namespace skein {

/// Parts that the plan has no use for are absent.
struct Surroundings {
    std::shared_ptr<Exposure> exposure; ///< where rods feel each other
    std::shared_ptr<SlotLoads> loads;   ///< where rods feel each other
    double meeting_zone = 0;            ///< gap of bodies that have slopes before they touch, m
    std::shared_ptr<FluidLoads> fluid;  ///< where rods feel a fluid
    std::shared_ptr<Walls> walls;
    std::shared_ptr<RelaxationResidual> residual; ///< where rods relax
    std::shared_ptr<const JointLists> joints;     ///< where there are assemblies
    std::vector<std::shared_ptr<WallContacts>>
        wall_contacts;                             ///< by program, once the rods are made; null where no wall acts
    std::vector<std::shared_ptr<BedFigures>> beds; ///< by program, once the rods are made; null where steps are others
};

/// A physics of the plan whose passes share data with what runs it.
class SharesWithPasses {
public:
    virtual ~SharesWithPasses() = default;
    /// Adds these. `owned`: bodies of this rank, in the order of their tiles.
    virtual void share(Surroundings& around, std::span<const RodGroup> groups,
                       std::span<const LocalRod> owned) const = 0;
};

} // namespace skein
