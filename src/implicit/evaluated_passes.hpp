// Implicit steps as passes: what makes them, and what they take over from their program.
#pragma once

#include "contact/tangent_lanes.hpp"
#include "implicit/bed_figures.hpp"
#include "mechanics/audit.hpp"
#include "mechanics/kick.hpp"
#include "mechanics/moving_ends.hpp"
#include "neighbourhood/exposure.hpp"

#include <memory>
#include <vector>

namespace skein {

/// A pass of the step that adds loads, which implicit steps evaluate by themselves.
template <int W> struct EvaluatedPass {
    std::unique_ptr<TilePass<W>> pass;
    bool has_slopes; ///< false where its loads do not change with the motion
};

/// Pass that evaluates others of its program by itself.
template <int W> class EvaluatesPasses {
public:
    virtual ~EvaluatesPasses() = default;
    virtual void take(std::vector<EvaluatedPass<W>> passes) = 0;
    virtual std::span<const EvaluatedPass<W>> evaluated() const = 0;
    /// Keeps the memory that its steps change in one of two places, and takes it back.
    virtual void keep(std::size_t) {}
    virtual void go_back(std::size_t) {}
};

/// Numbers of a group's implicit steps.
template <int W> struct ImplicitParts {
    const RodGroup& group;
    Law law;
    DampingRates rates;
    std::shared_ptr<EndWalls<W>> walls;
    KickedShares shares;                    ///< of the inertia
    std::shared_ptr<EnergyBudget<W>> audit; ///< null where there is none
    bool conserves;                         ///< by conserving_pass.hpp
};

/// Numbers of the steps of a group in a bed.
template <int W> struct BedParts {
    ImplicitParts<W> rod;
    std::shared_ptr<const Exposure> exposure; ///< null where rods do not feel each other
    std::shared_ptr<const SlotLoads> loads;
    std::shared_ptr<WallTangents<W>> tangents; ///< null where no wall acts
    std::shared_ptr<BedTiles<W>> figures;
};

/// The passes of implicit_pass.hpp or conserving_pass.hpp, and of bed_pass.hpp, which are compiled by themselves.
template <int W> std::unique_ptr<TilePass<W>> make_implicit_pass(const ImplicitParts<W>& parts);
template <int W> std::unique_ptr<TilePass<W>> make_bed_pass(const BedParts<W>& parts);

} // namespace skein
