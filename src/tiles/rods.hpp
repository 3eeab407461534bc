// All rods that this rank owns, as tiles of W lanes; the face that simulation, io and diagnostics see.
#pragma once

#include "core/hash.hpp"
#include "skein/rod/rod_group.hpp"
#include "skein/rod/slot.hpp"
#include "skein/time/clock.hpp"
#include "tiles/pass_effect.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
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

/// Energy budget of a rod since its audit began, J: work of loads, work of walls, energy dissipated. See
/// mechanics/audit.hpp.
struct RodBudget {
    double loads = 0, walls = 0, dissipated = 0;
    double held_before = 0; ///< kinetic energy of held nodes and elements, between the halves of a step
};

/// What a copy of a rod's state is to hold.
enum class Copy {
    canonical,    ///< the state as it is stored, and its hash
    positions,    ///< nodes at the time of the rates
    synchronised, ///< elements too
    frames,       ///< the same, and directors as matrices
    strained      ///< the same, and strains at nodes
};
constexpr bool has_frames(Copy copy) { return copy == Copy::frames || copy == Copy::strained; }

/// How a rod is strained at a node; see mechanics/rod_profile.hpp.
template <class P> struct NodeProfileOf {
    P strain;    ///< axial, e - e0; mean of the elements that meet here
    P curvature; ///< of the axis, 1/m; 0 at ends, unless they are clamped
    P energy;    ///< elastic, J per metre of rest length
};
using NodeProfile = NodeProfileOf<double>;

/// A rod's state, put together from the lanes; valid while the reader is called.
struct RodCopy {
    std::span<const Slot<1>> state;       ///< [n + 1]
    std::span<const Mat3d> frames;        ///< [n], rows d1 d2 d3; where has_frames(copy)
    std::span<const NodeProfile> profile; ///< [n + 1]; of Copy::strained
    std::uint64_t hash = 0;               ///< hash_rod; of Copy::canonical

    /// d1 at a node, of a copy with frames: mean of the elements that meet there.
    Vec3d normal(std::size_t node) const {
        return 0.5 * (frames[node > 0 ? node - 1 : 0].d1 + frames[std::min(node, frames.size() - 1)].d1);
    }
};
using RodReader = std::function<void(int thread, std::size_t i, const RodCopy& copy)>;

/// What one rod adds to sums over the scene, and to extremes.
struct RodFigures {
    enum Sum {
        translation, ///< kinetic energy, J
        rotation,
        stretch, ///< elastic energy, J; bending of half cells at walls included
        shear,
        bend,
        twist,
        momentum_x, ///< kg m/s, lab
        momentum_y,
        momentum_z,
        mass_x, ///< mass times position, kg m
        mass_y,
        mass_z,
        mass,
        sums
    };
    enum Extreme {
        speed,  ///< of a node, m/s
        strain, ///< axial
        turn,   ///< of neighbouring elements against each other, rad
        skew,   ///< of directors from unit length
        extremes
    };
    double sum[sums];
    double extreme[extremes];
};

class Rods {
public:
    virtual ~Rods() = default;

    /// Advances every rod by the given steps, tile by tile. With `check`, false if a rod is invalid (see inspect).
    virtual bool advance(std::span<const Step> steps, bool check) = 0;
    /// The halves of a step of rods that feel each other: before and after their coupling; with `check`, the second
    /// returns false if a rod is invalid.
    virtual void drift(const Step& step) = 0;
    virtual bool kick(const Step& step, bool check) = 0;
    /// kick(step), then drift(next), in one visit to each tile. Steps of different slots.
    virtual void kick_and_drift(const Step& step, const Step& next) = 0;
    /// Readies the passes of new rods, whose states are put in between the halves of this step, for the second half.
    virtual void begin_within(const Step& step) = 0;
    /// Names the rod whose strains leave the step least room, where the last check found one that is near its limit
    /// (mechanics/step_watch.hpp).
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
    /// Calls reader(thread, i, copy) with a copy of local()[rods[i]] for every i, on all threads, tile by tile; where
    /// rods are few, threads share tiles. `rods`: rising. `lag`: time that copies which are not canonical are moved on
    /// by; `time`: when walls that turn are where strained ones see them.
    virtual void read(std::span<const std::size_t> rods, Copy copy, double lag, const RodReader& reader,
                      double time = 0) const = 0;
    /// Of every owned rod, [local], of copies moved on by `lag` to `time`.
    virtual void figures(double time, double lag, std::span<RodFigures> out) const = 0;
    /// Sum over owned rods of a hash of (gid, canonical state), modulo 2^64: order-free, so equal for any distribution.
    virtual std::uint64_t digest() const = 0;
    /// Throws NumericalError naming rod, element and quantity where a rod is invalid: not finite, an element turned
    /// over, or strains at which the step is too long.
    virtual void inspect(std::int64_t step, double dt) const = 0;
    /// Energy budget of local()[i]; zeros without an audit.
    virtual RodBudget budget(std::size_t i) const = 0;
    /// Goes on from sums that a checkpoint kept; nothing without an audit.
    virtual void set_budget(std::size_t i, const RodBudget& budget) = 0;
    /// What passes remember of local()[i] from step to step: the same numbers for any width and lane.
    virtual std::vector<double> memory(std::size_t i) const = 0;
    virtual void set_memory(std::size_t i, std::span<const double> numbers) = 0;
    /// Threads that work on rods.
    virtual int threads() const = 0;
    /// Makes the stages of one step with local()[i] and those beside it in its tile, and tells what each pass did to
    /// it, in order. What others do to it is taken to be what they last did. For a look back, before the state is put
    /// back.
    virtual std::vector<PassEffect> dissect(std::size_t i, std::span<const Step> stages) {
        static_cast<void>(i);
        static_cast<void>(stages);
        return {};
    }
    /// Bytes held for state, parameters and scratch.
    virtual std::size_t bytes() const = 0;
    /// The largest share that the step had of what strains left of its limit, at any check and of any rod without
    /// damping, where it was beyond StepWatch::feeds; else 0.
    virtual double undamped_share() const { return 0; }
};

/// Of its canonical state: the term of the state digest.
std::uint64_t hash_rod(std::int64_t gid, std::span<const Slot<1>> state);

} // namespace skein
