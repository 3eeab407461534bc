// What a pass does to one rod in a step: for those who ask why a rod is invalid.
#pragma once

#include "skein/rod/rod_group.hpp"
#include "skein/rod/slot.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// The largest load that a pass adds, by what it would do within the step to what it acts on: a node moves by h^2 F/(m
/// l) of an element's length, an element turns by h^2 |C/J| rad. Both are far below 1 where the step resolves the
/// motion.
struct PassEffect {
    std::string_view pass;
    bool finite = true; ///< all numbers of rod and loads are, after it
    int at = 0;         ///< node or element of that load, or of the first number that is not finite
    bool turns = false; ///< a couple, and not a force
    double load = 0;    ///< N or N m
    double share = 0;   ///< of the length, or rad
};

/// Compares the loads of one rod before and after passes.
class PassWatch {
public:
    explicit PassWatch(const RodGroup& group);
    /// A stage begins: there are no loads.
    void begin();
    /// `force` (lab, N) and `couple` (body, N m) after a pass, by slot. With `adds` false the pass moves loads about
    /// and brings none.
    void look(PassEffect& effect, std::span<const Slot<1>> state, std::span<const Vec3d> force,
              std::span<const Vec3d> couple, double dt, bool adds);

private:
    const RodGroup& group_;
    std::vector<Vec3d> force_, couple_; ///< before
};

} // namespace skein
