// External loads and damping as a scene states them. Each load lives in one file of its own (loads/<kind>.hpp); this is the
// table of all of them. A new load: one file, and one line in `Load`.
#pragma once

#include "loads/damping.hpp"
#include "loads/end_force.hpp"
#include "loads/gravity.hpp"
#include "loads/magnetic_field.hpp"
#include "loads/muscle_torques.hpp"
#include "loads/muscle_wave.hpp"
#include "loads/plane_friction.hpp"
#include "loads/sinusoidal_end_force.hpp"
#include "loads/slender_body_drag.hpp"
#include "loads/uniform_couple.hpp"
#include "loads/uniform_force.hpp"

#include <string>
#include <variant>
#include <vector>

namespace skein {

using Load = std::variant<Gravity, UniformForce, UniformCouple, EndForce, MagneticField, MuscleWave, SinusoidalEndForce,
                          SlenderBodyDrag, MuscleTorques, PlaneFriction>;

/// Loads that look along a rod from end to end, which strands do not.
template <class L> inline constexpr bool needs_whole_rods = requires { requires L::needs_whole_rods; };
/// Loads that answer what everything else presses with: they come after contacts and walls.
inline bool feels_all(const Load& load) {
    return std::visit(
        []<class L>(const L&) {
            return requires { requires L::feels_all; };
        },
        load);
}
/// Loads that keep tables of their group.
template <class L> inline constexpr bool keeps_tables_of_group = requires(L l, const RodGroup& g) { l.bind_group(g); };

/// A load and the groups of rods it acts on (all where the list is empty).
struct LoadSpec {
    Load load;
    std::vector<std::string> rods;
    std::string source; ///< file:line of the table, for messages
};

struct DampingSpec {
    Damping damping;
    std::vector<std::string> rods;
    std::string source;
};

/// The name a scene gives to a load.
inline std::string_view kind_of(const Load& load) {
    return std::visit([](const auto& l) { return std::decay_t<decltype(l)>::kind; }, load);
}

} // namespace skein
