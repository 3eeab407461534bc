// A rod of a reference file: constants as the file has them, its state and loads, and its step with the published
// conventions made of the library's passes. What acts between systems stands between the two halves of a step.
#pragma once

#include "constraints.hpp"
#include "entry.hpp"

#include "kernels/rod_tiles.hpp"

namespace skein::replay {

struct Rod {
    RodGroup group;
    std::vector<Slot<1>> slot;           ///< [n + 1]; a ring's last slot is a copy of the first node
    std::vector<SlotLoad<1>> internal;   ///< [n + 1], force at nodes (lab, N), couple at elements (body, N m)
    std::vector<SlotLoad<1>> external{}; ///< [n + 1], of the step so far: published codes clear them once a step

    std::size_t elements() const { return slot.size() - 1; }
    std::size_t nodes() const { return group.closed() ? elements() : slot.size(); }
    Vec3d position(std::size_t node) const { return lane(slot[node].position, 0); }
    Vec3d velocity(std::size_t node) const { return lane(slot[node].velocity, 0); }
    RodTile<1> tile() { return tile_of(group, slot); }
};

/// `entry` of `systems`, a rod.
Rod read_rod(const Entry& entry, int number);

struct Stepping {
    Scheme scheme;
    double dt; ///< s
};

/// The step of one rod.
class RodProgram {
public:
    /// `constraints`, `dampers`: entries of the file's lists that act on this rod.
    RodProgram(Rod& rod, const Stepping& stepping, const std::vector<Entry>& constraints,
               const std::vector<Entry>& dampers);

    void prepare(std::span<const Step> steps);
    /// Drift, constraints on values, internal loads.
    void move(const Step& step) const;
    /// Kick by internal and external loads, constraints on rates, dampers.
    void kick(const Step& step) const;
    /// The state moved on to the end of its step.
    std::vector<Slot<1>> closed_state(double lag, double time) const;

private:
    Rod& rod_;
    TilePasses<1> move_, kick_;
    std::vector<std::shared_ptr<const Constraint>> constraints_;
    mutable std::vector<SlotLoad<1>> load_; ///< internal and external; passes of the kick use it as scratch
};

} // namespace skein::replay
