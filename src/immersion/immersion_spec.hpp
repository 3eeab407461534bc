// How a scene wants bodies in the fluid to act on it.
#pragma once

#include "immersion/direct_forcing.hpp"
#include "skein/core/fields.hpp"

#include <string_view>

namespace skein {

/// Whether rods feel the fluid.
enum class RodCoupling {
    two_way, ///< they do
    one_way  ///< they move as if there were none, and move the fluid
};
inline constexpr std::string_view rod_coupling_names[] = {"two_way", "one_way"};

/// [immersion]
struct ImmersionSpec {
    DeltaKind delta = DeltaKind::three_point;
    long sweeps = 2;
    double slip = 0;         ///< m/s
    double retraction = 0.4; ///< of rods, over the spacing of the grid
    RodCoupling coupling = RodCoupling::two_way;

    ForcingNumbers numbers() const { return {delta, static_cast<int>(sweeps), slip}; }
    void fields(FieldVisitor& f);
};

} // namespace skein
