// One damping table of every kind, for tests that hold for all of them. A new kind does not compile until it is here.
#pragma once

#include "loads/damping.hpp"
#include "skein/core/index.hpp"

#include <vector>

namespace skein::test {

/// Slow motion of simple_rod fades at some 20/s; alternating motion of the filter at 2000/s.
inline Damping damper(DampingKind kind) {
    switch (kind) {
    case DampingKind::uniform:
        return {.kind = kind, .rate = 20};
    case DampingKind::legacy:
        return {.kind = kind, .rate = 0.005};
    case DampingKind::physical:
        return {.kind = kind, .translational = 2, .rotational = 7e-4};
    case DampingKind::laplacian:
        return {.kind = kind, .rate = 2000, .order = 1};
    }
    return {};
}

/// Those that exert no force on the rod as a whole.
inline bool keeps_momentum(DampingKind kind) { return is_filter({.kind = kind}); }

inline std::vector<DampingKind> all_dampers() {
    std::vector<DampingKind> kinds;
    for (std::size_t i = 0; i < std::size(damping_names); ++i) kinds.push_back(static_cast<DampingKind>(i));
    return kinds;
}

inline std::string_view name_of(DampingKind kind) { return nth(damping_names, kind); }

} // namespace skein::test
