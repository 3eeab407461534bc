// Markers of rods and bodies in a fluid and shares of their inertia, once for all of a group that are alike, and once
// for each rod with sizes of its own.
#pragma once

#include "immersion/inertia_in_fluid.hpp"
#include "immersion/rod_surface.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace skein {

class ImmersedKinds {
public:
    struct Numbers {
        double retraction = 0;     ///< of markers within the surface, m
        double density = 0;        ///< of the fluid, kg/m^3
        bool has_inner = true;     ///< the fluid within moves with the rods
        bool feels_fluid = false;  ///< rods feel it
        bool sharp_bodies = false; ///< rigid bodies that are thick enough have sharp surfaces, not markers
        bool sharp_rods = false;   ///< and so have rods where they are thick enough
    };
    ImmersedKinds(const FluidGrid& grid, const Numbers& numbers) : grid_(grid), numbers_(numbers) {}

    struct Kind {
        std::vector<RodMarker> markers;                ///< none where all of the surface is sharp
        bool sharp = false;                            ///< some part of the surface is
        std::vector<double> sharp_shares;              ///< of such a rod, by node: see sharp_shares()
        std::shared_ptr<const InertiaInFluid> inertia; ///< null where rods do not feel the fluid
    };
    /// True if the scene asks for sharp surfaces of such groups.
    bool asks_sharp(const RodGroup& group) const { return group.body() ? numbers_.sharp_bodies : numbers_.sharp_rods; }
    /// Markers and inertia of rod i of a group; of a group that is RodGroup::kind, those of its rod, whatever i. Any
    /// thread may ask.
    const Kind& of(const RodGroup& group, std::int64_t i) const;

private:
    /// True for bodies with sharp surfaces: all parts are two cells thick at least.
    bool sharp_body(const BodyShape& body) const;
    Kind kind_of(const RodGroup& own) const;

    FluidGrid grid_;
    Numbers numbers_;
    mutable std::mutex mutex_;
    mutable std::map<std::pair<int, std::int64_t>, std::unique_ptr<const Kind>> kinds_; ///< by group and rod
};

} // namespace skein
