// Damping as scenes state it. Rates enter the kick (mechanics/kick.hpp), not the loads. theory.md (22)-(24)
//   uniform(c):      nu = c for velocity and spin                                         [1/s]
//   legacy(c):       nu = c for velocity; spin decays at c m_k e_k/J_i about axis i       [1/s]   (published codes)
//   physical(ct,cr): nu = ct/m_i for velocity; cr e_k/J_i for spin                        [kg/s], [kg m^2/s]
//   laplacian(p, c): a filter in the middle of the kick: rate c for what alternates from node to node
//                    (loads/laplacian_filter.hpp)                                         [1/s]
#pragma once

#include "mechanics/kick.hpp"
#include "skein/core/fields.hpp"

#include <span>

namespace skein {

enum class DampingKind { uniform, legacy, physical, laplacian };
inline constexpr std::string_view damping_names[] = {"uniform", "legacy", "physical", "laplacian"};

struct Damping {
    DampingKind kind = DampingKind::uniform;
    double rate = 0;          ///< c, 1/s
    double translational = 0; ///< ct, kg/s
    double rotational = 0;    ///< cr, kg m^2/s
    long order = 0;           ///< p

    void fields(FieldVisitor& f) {
        f.choice({.name = "kind", .text = "damping law", .required = true}, kind, damping_names);
        f.visit({.name = "rate",
                 .unit = "1/s",
                 .text = "uniform, legacy: c; laplacian: decay rate of motion with alternating sign from node to node",
                 .at_least = 0},
                rate);
        f.visit({.name = "translational", .unit = "kg/s", .text = "physical: ct", .at_least = 0}, translational);
        f.visit({.name = "rotational", .unit = "kg m^2/s", .text = "physical: cr", .at_least = 0}, rotational);
        f.visit({.name = "order",
                 .unit = "-",
                 .text = "laplacian: p; waves with a phase t from node to node decay at `rate` times sin(t/2)^(2p), so "
                         "a higher order damps long waves less",
                 .at_least = 0,
                 .at_most = 1000},
                order);
    }
};

/// When a filter acts: between the halves of a kick; for half of a step of any length, before it and after it; or after
/// it for the whole.
enum class FilterTime { in_kick, before_step, after_step, whole_step };

inline bool is_filter(const Damping& d) { return d.kind == DampingKind::laplacian; }

/// Rates of all damping tables of a group, summed; a filter has none.
DampingRates damping_rates(const RodGroup& group, std::span<const Damping> damping);

} // namespace skein
