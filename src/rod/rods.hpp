// All rods that this rank owns, as tiles of W lanes; the face that simulation, io and diagnostics see.
#pragma once

#include "rod/pass_effect.hpp"
#include "rod/rod_group.hpp"
#include "rod/slot.hpp"
#include "time/clock.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skein {

/// A rod owned by this rank.
struct LocalRod {
    std::int64_t gid;   ///< number of the rod in the scene; never changes
    int group;          ///< which RodGroup
    std::int64_t index; ///< number of the rod in its group
};

/// Where a rod lies: a tile, by its number within its group, and a lane of it.
struct RodPlace {
    std::size_t tile;
    int lane;
};

/// What has been done to a rod since the audit began, J. See rod/audit.hpp.
struct RodWorks {
    double loads = 0, walls = 0, dissipated = 0;
};

class Rods {
public:
    virtual ~Rods() = default;

    /// Advances every rod by the given steps, tile by tile. With `check`, false if a rod came out unfit (see inspect).
    virtual bool visit(std::span<const Step> steps, bool check) = 0;
    /// A step of rods that feel each other, in two halves: `move` until they meet, `act` from there; the second tells what visit
    /// does.
    virtual void move(const Step& step) = 0;
    virtual bool act(const Step& step, bool check) = 0;
    /// act(step), then move(next), in one visit to each tile. Steps of different slots.
    virtual void act_and_move(const Step& step, const Step& next) = 0;
    /// Names the rod whose strains leave the step least room, where the last check found one that is near its limit
    /// (rod/step_watch.hpp).
    virtual std::string near_limit() const = 0;

    /// Names of the passes of a group's rods that lie across, in order; none where no rod does.
    virtual std::vector<std::string_view> passes(std::size_t group) const = 0;
    /// Owned rods, ordered by group, within a group in space order.
    virtual std::span<const LocalRod> local() const = 0;
    /// Of local()[i], where rods lie across.
    virtual RodPlace place(std::size_t i) const = 0;
    /// Copies the canonical (staggered) state of local()[i] out or in; one slot per node.
    virtual void export_rod(std::size_t i, std::span<Slot<1>> out) const = 0;
    virtual void import_rod(std::size_t i, std::span<const Slot<1>> in) = 0;
    /// Sum over owned rods of a hash of (gid, canonical state), modulo 2^64: order-free, so equal for any distribution.
    virtual std::uint64_t digest() const = 0;
    /// Throws NumericalError naming rod, element and quantity where a rod is unfit: not finite, an element turned over, or strains
    /// at which the step is too long.
    virtual void inspect(std::int64_t step, double dt) const = 0;
    /// Of local()[i]; zeros without an audit.
    virtual RodWorks works(std::size_t i) const = 0;
    /// Goes on from sums that a checkpoint kept; nothing without an audit.
    virtual void set_works(std::size_t i, const RodWorks& works) = 0;
    /// What passes remember of local()[i] from step to step: the same numbers for any width and lane.
    virtual std::vector<double> memory(std::size_t i) const = 0;
    virtual void set_memory(std::size_t i, std::span<const double> numbers) = 0;
    /// Makes the stages of one step with local()[i] and those beside it in its tile, and tells what each pass did to it, in order.
    /// What others do to it is taken to be what they last did. For a look back, before the state is put back.
    virtual std::vector<PassEffect> dissect(std::size_t i, std::span<const Step> stages) {
        static_cast<void>(i), static_cast<void>(stages);
        return {};
    }
    /// Bytes held for state, parameters and scratch.
    virtual std::size_t bytes() const = 0;
};

/// Hash of numbers that belong to a rod (FNV-like over 64-bit words, finalised).
std::uint64_t hash_numbers(std::int64_t gid, std::span<const double> numbers);
/// Of its canonical state: the term of the state digest.
std::uint64_t hash_rod(std::int64_t gid, std::span<const Slot<1>> state);

/// Positions and directors moved on by `h` at constant rates: a synchronised copy for outputs and diagnostics.
void synchronise(const RodGroup& group, std::span<Slot<1>> state, double h);
/// The same of positions alone: most of the time goes into directors.
void synchronise_positions(const RodGroup& group, std::span<Slot<1>> state, double h);

} // namespace skein
