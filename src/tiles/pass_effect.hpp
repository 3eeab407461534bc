// Effect of a pass on one rod in a step, for the diagnosis of an invalid rod.
#pragma once

#include "skein/rod/rod_group.hpp"
#include "skein/rod/slot.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// Largest load that a pass adds, measured by its effect within the step. A node moves by h^2 F/(m l) of an element's
/// length; an element turns by h^2 |C/J| rad. Both are far below 1 where the step resolves the motion.
struct PassEffect {
    std::string_view pass;
    bool finite = true; ///< true while all numbers of rod and loads are finite after the pass
    int at = 0;         ///< node or element of that load, or of the first number that is not finite
    bool turns = false; ///< true for a couple, false for a force
    double load = 0;    ///< N or N m
    double share = 0;   ///< share of the element's length, or rad
};

/// Compares the loads of one rod before and after passes.
class PassWatch {
public:
    explicit PassWatch(const RodGroup& group);
    /// Begins a stage, in which there are no loads yet.
    void begin();
    /// Compares `force` (lab, N) and `couple` (body, N m) after a pass, by slot. With `adds` false the pass moves loads
    /// from slot to slot and adds none.
    void compare(PassEffect& effect, std::span<const Slot<1>> state, std::span<const Vec3d> force,
                 std::span<const Vec3d> couple, double dt, bool adds);

private:
    const RodGroup& group_;
    std::vector<Vec3d> force_, couple_; ///< loads before the pass
};

} // namespace skein
