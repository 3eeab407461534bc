// How a scene wants bodies in the fluid to act on it.
#pragma once

#include "immersion/direct_forcing.hpp"
#include "skein/core/fields.hpp"

namespace skein {

/// [immersion]
struct ImmersionSpec {
    DeltaKind delta = DeltaKind::three_point;
    long sweeps = 2;
    double slip = 0; ///< m/s

    ForcingNumbers numbers() const { return {delta, static_cast<int>(sweeps), slip}; }
    void fields(FieldVisitor& f);
};

} // namespace skein
