// Speeds that a scene states, against the sizes of what may meet: how long a step may be in which they are seen to
// meet, and contacts that are too soft to stop them. theory.md (58c)
#pragma once

#include "physics/scene_spec.hpp"
#include "skein/rod/rod_group.hpp"

#include <span>
#include <string>
#include <vector>

namespace skein {

class ContactLaws;
struct ContactSpec;

/// Two that may meet, a group and a group or a wall, at the largest speed that the scene states of them.
struct Meeting {
    std::string who;                                           ///< "'left' and 'right'"
    double speed = 0;                                          ///< m/s
    double diameter = 0;                                       ///< of the thinnest element of both, m
    double allowed = 0;                                        ///< overlap, over the diameter
    double step() const { return allowed * diameter / speed; } ///< s, in which they move by that
};

struct SpeedEstimate {
    Meeting fastest; ///< that leaves the shortest step; speed 0: the scene states no speed of what may meet
    std::vector<std::string> doubts; ///< contacts that what meets would pass through
    double longest_step() const;     ///< s
    /// Doubts about a longer step; empty: it is not longer.
    std::vector<std::string> doubts_of_step(double dt) const;
};

/// `laws`: by pair of groups; null where rods do not feel each other.
SpeedEstimate speed_estimate(const SceneSpec& scene, const ContactLaws* laws, std::span<const RodGroup> groups);

} // namespace skein
